// Least-squares rigid fits from moments, and poses between the working frame and the caller's.
#pragma once

#include <Eigen/Geometry>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// A rigid motion in double precision. Unaligned storage: the layout is the same whatever -m flags a program is built
/// with.
using RigidTransform = Eigen::Transform<double, 3, Eigen::Isometry, Eigen::DontAlign>;
static_assert(sizeof(RigidTransform) == 16 * sizeof(double) && alignof(RigidTransform) == alignof(double));

/// The minimiser of sum w |R p + t - q|^2 over proper rotations, and how well the data determine it.
struct RigidFit {
  RigidTransform pose = RigidTransform::Identity();  ///< in the frame of the moments
  /// Singular values of the weighted cross-covariance sum w (q - qm)(p - pm)^T / sum w, descending; the last one
  /// negative when the best orthogonal matrix would be a reflection; zero when within the rounding of single-precision
  /// moments.
  Eigen::Matrix<double, 3, 1, Eigen::DontAlign> singular_values = Eigen::Matrix<double, 3, 1, Eigen::DontAlign>::Zero();

  /// False for fewer than three points' worth of data, coincident points, or points on a line: the rotation is not
  /// determined.
  [[nodiscard]] bool determined() const noexcept;
};
static_assert(sizeof(RigidFit) == 19 * sizeof(double) && alignof(RigidFit) == alignof(double));

/// Kabsch's fit (SVD with the determinant's sign), the paper's pose solver. Moments without weight give the identity,
/// not determined.
[[nodiscard]] RigidFit rigid_fit(const RigidMoments& moments);

/// Working-frame pose as the kernels take it.
[[nodiscard]] WorkingPose to_working_pose(const RigidTransform& pose) noexcept;
/// Its rotation is made orthonormal again in double precision.
[[nodiscard]] RigidTransform from_working_pose(const WorkingPose& pose);

/// A working-frame pose of `frame` as T_target_source in the caller's frame and unit, and back.
[[nodiscard]] RigidTransform to_caller_frame(const RigidTransform& working, const Correspondences& frame);
[[nodiscard]] RigidTransform to_working_frame(const RigidTransform& T_target_source, const Correspondences& frame);

}  // namespace consimd
