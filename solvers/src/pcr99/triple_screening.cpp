// Which of many triples are worth a pose.

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <numeric>

#include <consimd/solvers/pcr99.hpp>

#include "bits/bit_rows.hpp"

namespace consimd {
namespace {

constexpr std::size_t kTriplesPerTask = 256;

/// For each triple the number of rows that all three of its rows have set.
std::vector<std::uint32_t> common_neighbours(const ConsistencyMatrix& matrix, const std::vector<IndexTriple>& triples) {
  std::vector<std::uint32_t> counts(triples.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triples.size(), kTriplesPerTask), [&](const auto& range) {
    std::vector<std::uint64_t> both(matrix.words());
    for (std::size_t t = range.begin(); t != range.end(); ++t) {
      detail::intersect(matrix.row(triples[t].first), matrix.row(triples[t].second), both);
      counts[t] = and_popcount(both, matrix.row(triples[t].third));
    }
  });
  return counts;
}

}  // namespace

void keep_best_connected(const ConsistencyMatrix& matrix, std::size_t count, std::vector<IndexTriple>& triples) {
  if (triples.size() <= count) return;
  const std::vector<std::uint32_t> common = common_neighbours(matrix, triples);
  std::vector<std::uint32_t> kept(triples.size());
  std::iota(kept.begin(), kept.end(), 0U);
  const auto end = kept.begin() + static_cast<std::ptrdiff_t>(count);
  // A total order: the same triples are kept however the selection goes about it.
  std::ranges::nth_element(kept, end, [&](std::uint32_t a, std::uint32_t b) {
    return common[a] != common[b] ? common[a] > common[b] : a < b;
  });
  kept.erase(end, kept.end());
  std::ranges::sort(kept);
  for (std::size_t t = 0; t < count; ++t) triples[t] = triples[kept[t]];
  triples.resize(count);
}

}  // namespace consimd
