#include "support/supported_motion.hpp"

#include <Eigen/Core>

#include "support/row_blocks.hpp"
#include "support/source_scatter.hpp"

namespace consimd::detail {

SupportedMotion::SupportedMotion(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound)
    : pose_(from_working_pose(pose)),
      supporters_(row_blocks::robust_moments(view, pose, {.scale = noise_bound, .cutoff = noise_bound})),
      limit_(kSameMotion * noise_bound * view.scale()) {}

bool SupportedMotion::is_same(const WorkingPose& pose) const {
  const RigidMoments& s = supporters_;
  if (s.weight == 0.0) return false;
  const Eigen::Vector3d mean = Eigen::Vector3d(s.source) / s.weight;
  const RigidTransform other = from_working_pose(pose);
  const Eigen::Matrix3d turn = other.linear() - pose_.linear();
  const Eigen::Vector3d shift = other.translation() - pose_.translation();
  // mean of |turn p + shift|^2
  const double square = (turn * source_scatter(s) * turn.transpose()).trace() / s.weight +
                        2.0 * shift.dot(turn * mean) + shift.squaredNorm();
  return square < limit_ * limit_;
}

}  // namespace consimd::detail
