// The least-squares problem of one step of a refinement.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include <consimd/features/refinement.hpp>

#include "refinement/closest_pairs.hpp"

namespace consimd::features::detail {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What a pair adds to the normal equations of (omega, tau): x moves to x + omega cross (x - centre) + tau. Working
/// frame of the target. The squared residual is e^T metric e, its gradient 2 metric e.
struct PairTerm {
  Eigen::Vector3d arm;    ///< x - centre
  Eigen::Vector3d error;  ///< e = x - q
  double squared = 0.0;
  bool of_plane = false;
  Eigen::Vector3d normal;  ///< of_plane: the metric is normal normal^T
  Eigen::Matrix3d metric;  ///< else: positive semi-definite, at most 1 along any direction
};

/// Sums over pairs; only the lower triangle of `normal` counts.
struct NormalEquations {
  Matrix6d normal = Matrix6d::Zero();
  Vector6d score = Vector6d::Zero();
  double weight = 0.0;
  double spread = 0.0;          ///< w |arm|^2
  double squared_score = 0.0;   ///< w^2 r^2: of scores, per unit of the normal matrix once divided by `weight`
  double slope = 0.0;           ///< derivative of w r, summed: what a step really changes of the score
  double squared_length = 0.0;  ///< of what rmse is taken over
  std::size_t pairs = 0;

  void add(const PairTerm& term, double squared_scale);
  NormalEquations& operator+=(const NormalEquations& other);
};

/// The pairs' terms under one method.
class PairTerms {
 public:
  /// `rotation`: of the pose that `pairs` were moved by.
  PairTerms(const ClosestPairs& pairs, const CloudView& source, const CloudView& target, RefinementMethod method,
            const Eigen::Matrix3d& rotation, const Eigen::Vector3d& centre)
      : pairs_(pairs), source_(source), target_(target), method_(method), rotation_(rotation), centre_(centre) {}

  /// False where entry i is no pair, or lacks a normal that the method needs.
  [[nodiscard]] bool term(std::size_t i, PairTerm& term) const;

  /// Robust deviation of the residuals, by the median over up to some 4000 pairs; 0 without pairs.
  [[nodiscard]] double scale() const;

  /// In blocks, joined in order.
  [[nodiscard]] NormalEquations sum(double scale) const;

 private:
  const ClosestPairs& pairs_;
  CloudView source_;
  CloudView target_;
  RefinementMethod method_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d centre_;
};

/// Weight of a pair, by squared residual and squared scale of residuals.
[[nodiscard]] double pair_weight(double squared, double squared_scale) noexcept;

}  // namespace consimd::features::detail
