// The rows that a pairwise matrix is made of, within a budget of memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// The least budget that `matrices` are given: a sample of fewer than a few hundred rows tells little of thousands.
std::size_t least_matrix_budget(std::size_t matrices);

/// Rows that `matrices` of their bit matrices fit the budget with.
std::size_t rows_within(std::size_t budget_bytes, std::size_t matrices);

/// All rows, or a random sample of as many as `matrices` of their bit matrices fit the budget, ascending.
class MatrixSample {
 public:
  /// Keeps a reference to the correspondences.
  MatrixSample(const Correspondences& correspondences, std::size_t matrices, std::size_t budget_bytes,
               std::uint64_t seed);

  /// The sampled rows, in the working frame of all.
  [[nodiscard]] const Correspondences& correspondences() const noexcept { return rows_.empty() ? all_ : sample_; }
  /// Row of the original that is row `position` of the sample.
  [[nodiscard]] std::uint32_t row(std::uint32_t position) const { return rows_.empty() ? position : rows_[position]; }

 private:
  const Correspondences& all_;
  std::vector<std::uint32_t> rows_;  // empty: all
  Correspondences sample_;
};

}  // namespace consimd::detail
