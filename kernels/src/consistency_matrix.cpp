#include <consimd/kernels/consistency_matrix.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

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
  resize(view);
  detail::active_table().consistency_matrix(detail::raw_view(view), length, storage_.data(), degrees_.data());
}

void ConsistencyMatrix::compute_separated(const CorrespondenceView& view, double bound, double separation) {
  const detail::SeparatedBounds bounds{detail::working_length(view, bound, "bound"),
                                       detail::working_length(view, separation, "separation")};
  resize(view);
  detail::active_table().separated_matrix(detail::raw_view(view), bounds, storage_.data(), degrees_.data());
}

void ConsistencyMatrix::compute_ratio(const CorrespondenceView& view, double bound, double ratio_bound) {
  const detail::RatioBounds bounds{detail::working_length(view, bound, "bound"),
                                   detail::ratio_bound(ratio_bound, "ratio_bound")};
  resize(view);
  detail::active_table().ratio_matrix(detail::raw_view(view), bounds, storage_.data(), degrees_.data());
}

void ConsistencyMatrix::resize(const CorrespondenceView& view) {
  size_ = view.size();
  words_ = view.words();
  storage_.resize(size_ * words_);
  degrees_.resize(size_);
}

std::uint32_t popcount(std::span<const std::uint64_t> bits) { return and_popcount(bits, bits); }

std::uint32_t and_popcount(std::span<const std::uint64_t> a, std::span<const std::uint64_t> b) {
  detail::require_size("b", b.size(), a.size());
  return detail::active_table().and_popcount(a.data(), b.data(), a.size());
}

void and_popcount_rows(const ConsistencyMatrix& matrix, std::span<const std::uint64_t> set,
                       std::span<const std::uint32_t> rows, std::span<std::uint32_t> counts) {
  detail::require_size("set", set.size(), matrix.words());
  and_popcount_rows({matrix.data(), matrix.size() * matrix.words()}, set, rows, counts);
}

void and_popcount_rows(std::span<const std::uint64_t> bits, std::span<const std::uint64_t> set,
                       std::span<const std::uint32_t> rows, std::span<std::uint32_t> counts) {
  const std::size_t size = set.empty() ? 0 : bits.size() / set.size();
  detail::require_size("bits", bits.size(), size * set.size());
  detail::require_size("counts", counts.size(), rows.size());
  if (rows.empty()) return;
  detail::require_index(*std::max_element(rows.begin(), rows.end()), size);
  detail::active_table().and_popcount_rows(bits.data(), set.size(), set.data(), rows.data(), rows.size(),
                                           counts.data());
}

void masked_row_sums(const ConsistencyMatrix& matrix, std::size_t first_row, std::span<const float> values,
                     std::span<float> sums) {
  detail::require_size("values", values.size(), matrix.words() * kBlock);
  if (first_row > matrix.size() || sums.size() > matrix.size() - first_row) {
    throw std::invalid_argument("sums of " + std::to_string(sums.size()) + " rows from row " +
                                std::to_string(first_row) + " on, expected rows of a matrix of " +
                                std::to_string(matrix.size()));
  }
  detail::active_table().masked_row_sums(matrix.data() + first_row * matrix.words(), matrix.words(), sums.size(),
                                         values.data(), sums.data());
}

}  // namespace consimd
