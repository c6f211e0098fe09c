// The pairwise length-consistency matrix of a set of correspondences as bits.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

#include <vector>

namespace CONSIMD_EXPORT consimd {

/// N x N symmetric bit matrix: bit j of row i tells whether i and j are length consistent (see length_consistency.hpp;
/// the diagonal is set). Rows are view.words() words; bits from N on are 0. Takes N * words * 8 bytes, 1.1 MB for N =
/// 3000: ask `memory_bytes` first when N is large.
class ConsistencyMatrix {
 public:
  ConsistencyMatrix() = default;

  [[nodiscard]] static std::size_t memory_bytes(std::size_t correspondences) noexcept;

  /// Fills the matrix, each pair once. Keeps its memory for the next call. bound: caller's unit, finite and > 0; the
  /// working frame resolves it as `working_length` says. Throws std::invalid_argument on a bad bound, std::bad_alloc
  /// without the memory.
  void compute(const CorrespondenceView& view, double bound);

  /// The same without short pairs, which determine a pose badly: bit j of row i also needs
  ///   |p_i - p_j| + |q_i - q_j| > separation,
  /// so the diagonal is clear. Without square roots: with a, b the squared lengths and m = separation^2 - (a + b),
  /// m < 0 or m^2 < 4 a b. separation: caller's unit, finite and > 0. Throws as `compute`.
  void compute_separated(const CorrespondenceView& view, double bound, double separation);

  /// The same where the ratio of the lengths is bounded as well: bit j of row i also needs, with a, b the squared
  /// lengths,
  ///   |b - a| < ratio_bound (a + b),
  /// which is |ln(b / a)| / 2 < artanh(ratio_bound), and false on the diagonal. ratio_bound: in (0, 1). Throws as
  /// `compute`.
  void compute_ratio(const CorrespondenceView& view, double bound, double ratio_bound);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t words() const noexcept { return words_; }
  [[nodiscard]] std::span<const std::uint64_t> row(std::size_t i) const noexcept {
    return {data() + i * words_, words_};
  }
  [[nodiscard]] const std::uint64_t* data() const noexcept { return storage_.data(); }
  /// Number of ones in each row, the diagonal included.
  [[nodiscard]] std::span<const std::uint32_t> degrees() const noexcept { return degrees_; }

 private:
  void resize(const CorrespondenceView& view);

  std::size_t size_ = 0;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> storage_;
  std::vector<std::uint32_t> degrees_;
};

/// Number of bits set in `bits`.
[[nodiscard]] std::uint32_t popcount(std::span<const std::uint64_t> bits);

/// Number of bits set in both a and b. Throws std::invalid_argument unless they have equal sizes.
[[nodiscard]] std::uint32_t and_popcount(std::span<const std::uint64_t> a, std::span<const std::uint64_t> b);

/// counts[r] = bits set in both `set` and row rows[r] of `matrix`: the degrees of chosen members within the set.
/// With set = matrix.row(i) and rows its neighbours j: the second-order measure of the edges (i, j), their common
/// neighbours (SC2 of Z. Chen et al., CVPR 2022); a set diagonal makes i and j count among these, 2 too many.
/// set: matrix.words() words; rows, counts: R. Throws std::invalid_argument on mismatched sizes, std::out_of_range on a
/// row that the matrix lacks.
void and_popcount_rows(const ConsistencyMatrix& matrix, std::span<const std::uint64_t> set,
                       std::span<const std::uint32_t> rows, std::span<std::uint32_t> counts);

/// The same for rows of bits that lie one after the other, each of set.size() words. Throws std::invalid_argument
/// unless `bits` are whole rows, or if counts and rows differ in size, std::out_of_range on a row that there is not.
void and_popcount_rows(std::span<const std::uint64_t> bits, std::span<const std::uint64_t> set,
                       std::span<const std::uint32_t> rows, std::span<std::uint32_t> counts);

/// sums[r] = sum of values[j] over the ones j of row first_row + r: rows of the product of the matrix and a vector.
/// Single precision, in 16 interleaved sums joined in one order: the same bits on every ISA. values: matrix.words() *
/// kBlock floats, of which those from matrix.size() on may be anything; sums: as many rows as are wanted. Throws
/// std::invalid_argument on other sizes.
void masked_row_sums(const ConsistencyMatrix& matrix, std::size_t first_row, std::span<const float> values,
                     std::span<float> sums);

}  // namespace consimd
