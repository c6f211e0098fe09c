#include <consimd/kernels/consistency_matrix.hpp>

#include "dispatch.hpp"
#include "kernel_arguments.hpp"

namespace consimd {
namespace {

std::size_t words_for(std::size_t correspondences) { return (correspondences + kBlock - 1) / kBlock; }

}  // namespace

std::size_t ConsistencyMatrix::memory_bytes(std::size_t correspondences) noexcept {
  return correspondences * words_for(correspondences) * sizeof(std::uint64_t);
}

void ConsistencyMatrix::compute(const CorrespondenceView& view, double bound) {
  const float length = detail::working_length(view, bound, "bound");
  size_ = view.size();
  words_ = view.words();
  storage_.resize(size_ * words_);
  degrees_.resize(size_);
  detail::active_table().consistency_matrix(detail::raw_view(view), length, storage_.data(), degrees_.data());
}

std::uint32_t popcount(std::span<const std::uint64_t> bits) { return and_popcount(bits, bits); }

std::uint32_t and_popcount(std::span<const std::uint64_t> a, std::span<const std::uint64_t> b) {
  detail::require_size("b", b.size(), a.size());
  return detail::active_table().and_popcount(a.data(), b.data(), a.size());
}

void and_popcount_rows(const ConsistencyMatrix& matrix, std::span<const std::uint64_t> set,
                       std::span<const std::uint32_t> rows, std::span<std::uint32_t> counts) {
  detail::require_size("set", set.size(), matrix.words());
  detail::require_size("counts", counts.size(), rows.size());
  for (const std::uint32_t row : rows) detail::require_index(row, matrix.size());
  detail::active_table().and_popcount_rows(matrix.data(), matrix.words(), set.data(), rows.data(), rows.size(),
                                           counts.data());
}

}  // namespace consimd
