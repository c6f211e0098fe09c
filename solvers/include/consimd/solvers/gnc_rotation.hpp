// The rotation between two sets of vectors by graduated non-convexity.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

struct GncRotationOptions {
  /// c: the largest error of an inlying difference vector, caller's unit: two noise bounds.
  double difference_bound = 0.0;
  /// Which differences of the members are measured: each with the next one, the last with the first; or all pairs.
  enum class Pairs : std::uint8_t { chain, all } pairs = Pairs::chain;
  double growth = 1.4;  ///< of the control parameter mu in a round, > 1
  std::uint32_t max_rounds = 100;
  /// The rounds end once the weighted cost, in squared bounds per measurement, changes by less.
  double smallest_change = 1e-6;
};

struct GncRotation {
  Eigen::Matrix<double, 3, 3, Eigen::DontAlign> rotation = Eigen::Matrix3d::Identity();  ///< source to target
  bool determined = false;
  std::uint32_t rounds = 0;
  std::size_t measurements = 0;
  std::size_t inliers = 0;  ///< measurements within the bound of the rotation
};
static_assert(alignof(GncRotation) == alignof(double));

/// Truncated least squares min_R sum min(|b - R a|^2, c^2) over differences a = p_j - p_i, b = q_j - q_i of the
/// members, which no translation changes. H. Yang, P. Antonante, V. Tzoumas, L. Carlone, "Graduated Non-Convexity for
/// Robust Spatial Perception: From Non-Minimal Solvers to Global Outlier Rejection", RA-L 2020: from mu = c^2 / (2
/// r_max^2 - c^2), where the cost is convex, to mu large, where it is the truncated one; each round fits by SVD with
/// the weights
///   1 where r^2 <= mu / (mu + 1) c^2,  0 where r^2 >= (mu + 1) / mu c^2,  else c / r sqrt(mu (mu + 1)) - mu.
/// members: rows of `correspondences`. Throws std::invalid_argument on a bad option.
[[nodiscard]] GncRotation gnc_rotation(const Correspondences& correspondences, std::span<const std::uint32_t> members,
                                       const GncRotationOptions& options);

}  // namespace consimd
