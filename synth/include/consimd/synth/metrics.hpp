// Errors of an estimated pose against the ground truth.
#pragma once

#include <cstdint>
#include <span>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// Angle of R_estimate R_truth^T in degrees, [0, 180], taken from the unit quaternions: accurate to rounding from 0 to
/// 180 degrees, where an arccosine loses half the digits.
[[nodiscard]] double rotation_error_deg(const RigidTransform& estimate, const RigidTransform& truth);

/// |t_estimate - t_truth|, caller's unit.
[[nodiscard]] double translation_error(const RigidTransform& estimate, const RigidTransform& truth);

/// |estimate / truth - 1|.
[[nodiscard]] double scale_error(double estimate, double truth);

/// Root mean square of |T (scale p) - q| over the true inliers, the study's success measure (success: < 3 sigma).
/// `scale` belongs to the estimate. NaN without inliers.
[[nodiscard]] double rmse_true_inliers(const Problem& problem, const RigidTransform& estimate, double scale = 1.0);

/// How a reported set of inliers compares with the true one. NaN where the denominator is empty.
struct InlierQuality {
  double precision;  ///< share of the reported rows that are true inliers
  double recall;     ///< share of the true inliers that are reported
};

/// reported: distinct rows of the problem, in any order. Throws std::out_of_range on a row that the problem lacks.
[[nodiscard]] InlierQuality inlier_quality(const Problem& problem, std::span<const std::uint32_t> reported);

/// The oracle: the least-squares rigid motion of the true inliers at the true scale, in double precision, which no
/// estimator that has to find them can be expected to beat. One of the minimisers for one or two inliers; all NaN, and
/// so its errors, without any.
[[nodiscard]] RigidTransform oracle(const Problem& problem);

}  // namespace synth
}  // namespace consimd
