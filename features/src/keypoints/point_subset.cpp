#include <consimd/features/point_subset.hpp>

#include <Random123/philox.h>

#include <algorithm>
#include <numeric>

namespace consimd::features {

std::vector<std::uint32_t> random_subset(std::size_t size, std::size_t count, std::uint64_t seed) {
  std::vector<std::uint32_t> rows(std::min(size, count));
  if (count >= size) {
    std::iota(rows.begin(), rows.end(), 0u);
    return rows;
  }
  // Selection sampling (Knuth, The Art of Computer Programming, vol. 2, algorithm S): a row is taken with the share of
  // those still wanted among those still to come.
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  constexpr std::uint32_t kStream = 100;  // none of the solvers'
  std::size_t taken = 0;
  for (std::size_t row = 0; taken < rows.size(); ++row) {
    const auto draws = r123::Philox4x32()({{0, kStream, static_cast<std::uint32_t>(row), 0}}, key);
    const std::uint64_t left = size - row;
    if (std::uint64_t{draws[0]} * left >> 32 < rows.size() - taken) rows[taken++] = static_cast<std::uint32_t>(row);
  }
  return rows;
}

}  // namespace consimd::features
