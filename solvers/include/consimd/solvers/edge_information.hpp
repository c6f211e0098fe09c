// A registration as an edge of a pose graph: its covariance as the information matrix that an optimiser takes.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

namespace CONSIMD_EXPORT consimd {

/// Whose error function an information matrix is made for. In all of them the measurement of the edge is
/// Z = T_target_source, X_target and X_source are the poses of the two scans in the world, and the error compares Z
/// with X_target^-1 X_source on its right side:
///   D = Z^-1 X_target^-1 X_source = [D_R, D_t],
/// a motion of the source frame, where the covariance of a registration has the axes of the target frame.
enum class PoseGraphLibrary : std::uint8_t {
  /// BetweenFactor<Pose3>(target, source, Z): Logmap(D), rotation vector (rad) before translation (gtsam/slam/
  /// BetweenFactor.h, gtsam/geometry/Pose3.h).
  gtsam,
  /// EdgeSE3 from the target's VertexSE3 to the source's: D_t before the vector part of D_R's unit quaternion, half the
  /// rotation vector (g2o/types/slam3d/edge_se3.cpp, toVectorMQT in isometry3d_mappings.cpp).
  g2o,
  /// PoseGraphEdge(source_node_id, target_node_id, Z, information): the antisymmetric part of D_R (the sine of the
  /// rotation) before D_t, as GlobalOptimization.cpp computes it. Open3D's own get_information_matrix_from_point_clouds
  /// counts points about the target's origin instead, as if motions were on the left side, and without their noise.
  open3d,
};

/// Rows and columns in the order of the library's error; symmetric. Unaligned storage, as that of RigidTransform.
using EdgeInformation = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;

/// The inverse of the covariance of the library's error where X_target^-1 X_source is the truth, first order in the
/// rotation: e^T information e has the mean 6. `T_target_source` and `covariance`: of a registration, in the unit of
/// the graph. Throws std::invalid_argument if the covariance is not positive definite: the registration has no pose,
/// did not estimate its covariance, or its sources are so far from their origin that lever arms leave no digits.
[[nodiscard]] EdgeInformation edge_information(const RigidTransform& T_target_source, const PoseCovariance& covariance,
                                               PoseGraphLibrary library);

}  // namespace consimd
