// The least-squares problem of one step of a refinement.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <consimd/features/refinement.hpp>
#include <consimd/kernels/pair_block.hpp>

#include "refinement/closest_pairs.hpp"

namespace consimd::features::detail {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What PairEquations has, over any number of pairs. Working frame of the target.
struct NormalEquations {
  Matrix6d normal = Matrix6d::Zero();  ///< only the lower triangle counts
  Vector6d score = Vector6d::Zero();
  double weight = 0.0;
  double spread = 0.0;
  double squared_score = 0.0;
  double slope = 0.0;
  double squared_length = 0.0;
  std::size_t pairs = 0;

  NormalEquations& operator+=(const PairEquations& part);
};

/// `rotation`: of the pose that the pairs were moved by; rotations of the step are taken about `centre`, working frame
/// of the target.
[[nodiscard]] PairProblem pair_problem(const ClosestPairs& pairs, RefinementMethod method,
                                       const Eigen::Matrix3d& rotation, const Eigen::Vector3d& centre);

/// Squared residuals of all entries, NaN where there is no pair.
[[nodiscard]] std::vector<float> squared_residuals(const ClosestPairs& pairs, const CloudView& target,
                                                   const PairProblem& problem);

/// Robust deviation of the residuals, by the median over up to some 4000 entries; 0 without pairs.
[[nodiscard]] double residual_scale(const std::vector<float>& squared, RefinementMethod method);

/// In blocks, joined in order. `problem` with its scale.
[[nodiscard]] NormalEquations sum_of(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem);

}  // namespace consimd::features::detail
