#include <consimd/poses/rigid_fit.hpp>

#include <Eigen/SVD>

namespace consimd {
namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

/// Rounding of single-precision sums relative to their largest terms, with room to spare.
constexpr double kMomentRounding = 0x1p-20;

Eigen::Vector3d vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

bool RigidFit::determined() const noexcept { return singular_values[1] > 0.0; }

RigidFit rigid_fit(const RigidMoments& moments) {
  RigidFit fit;
  if (!(moments.weight > 0.0)) return fit;
  const Eigen::Vector3d source_mean = Eigen::Map<const Eigen::Vector3d>(moments.source) / moments.weight;
  const Eigen::Vector3d target_mean = Eigen::Map<const Eigen::Vector3d>(moments.target) / moments.weight;
  const Eigen::Matrix3d second_moment = Eigen::Map<const RowMajor3d>(moments.cross) / moments.weight;
  const Eigen::Matrix3d covariance = second_moment - target_mean * source_mean.transpose();
  if (!covariance.allFinite()) return fit;

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool mirrored = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0;
  const Eigen::Vector3d signs(1.0, 1.0, mirrored ? -1.0 : 1.0);
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const double rounding = kMomentRounding * second_moment.norm();
  for (int k = 0; k < 3; ++k) {
    const double value = svd.singularValues()[k];
    fit.singular_values[k] = value > rounding ? signs[k] * value : 0.0;
  }
  fit.pose.linear() = rotation;
  fit.pose.translation() = target_mean - rotation * source_mean;
  return fit;
}

WorkingPose to_working_pose(const RigidTransform& pose) noexcept {
  WorkingPose working;
  Eigen::Map<RowMajor3f>(working.rotation) = pose.linear().cast<float>();
  Eigen::Map<Eigen::Vector3f>(working.translation) = pose.translation().cast<float>();
  return working;
}

RigidTransform from_working_pose(const WorkingPose& pose) {
  const Eigen::Matrix3d rounded = Eigen::Map<const RowMajor3f>(pose.rotation).cast<double>();
  RigidTransform rigid = RigidTransform::Identity();
  rigid.linear() = Eigen::Quaterniond(rounded).normalized().toRotationMatrix();
  rigid.translation() = Eigen::Map<const Eigen::Vector3f>(pose.translation).cast<double>();
  return rigid;
}

RigidTransform to_caller_frame(const RigidTransform& working, const Correspondences& frame) {
  RigidTransform T_target_source = working;
  T_target_source.translation() = working.translation() / frame.scale() + vector(frame.target_centroid()) -
                                  working.linear() * vector(frame.source_centroid());
  return T_target_source;
}

RigidTransform to_working_frame(const RigidTransform& T_target_source, const Correspondences& frame) {
  RigidTransform working = T_target_source;
  working.translation() = frame.scale() * (T_target_source.translation() - vector(frame.target_centroid()) +
                                           T_target_source.linear() * vector(frame.source_centroid()));
  return working;
}

}  // namespace consimd
