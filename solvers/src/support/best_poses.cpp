#include "support/best_poses.hpp"

#include <Eigen/Core>

#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "support/points.hpp"
#include "support/row_blocks.hpp"
#include "support/source_scatter.hpp"

namespace consimd::detail {
namespace {

constexpr double kSameMotion = 2.0;  // in noise bounds

}  // namespace

BestPoses::BestPoses(const Correspondences& correspondences, double noise_bound)
    : correspondences_(&correspondences), noise_bound_(noise_bound) {}

bool BestPoses::same_motion_as_best(const WorkingPose& pose) const {
  const RigidMoments& s = best_supporters_;
  if (s.weight == 0.0) return false;
  const Eigen::Vector3d mean = Eigen::Vector3d(s.source) / s.weight;
  const RigidTransform one = from_working_pose(best_.pose);
  const RigidTransform other = from_working_pose(pose);
  const Eigen::Matrix3d turn = other.linear() - one.linear();
  const Eigen::Vector3d shift = other.translation() - one.translation();
  // mean of |turn p + shift|^2
  const double square = (turn * source_scatter(s) * turn.transpose()).trace() / s.weight +
                        2.0 * shift.dot(turn * mean) + shift.squaredNorm();
  const double limit = kSameMotion * noise_bound_ * correspondences_->scale();
  return square < limit * limit;
}

bool BestPoses::explains(const PoseCandidate& candidate, std::uint32_t row) const {
  const CorrespondenceView view = correspondences_->view();
  return candidate.support.count >= 3 && distance(moved(candidate.pose, source_point(view, row)),
                                                  target_point(view, row)) < kSameMotion * noise_bound_ * view.scale();
}

void BestPoses::set_best(const PoseCandidate& candidate) {
  best_ = candidate;
  best_supporters_ =
      row_blocks::robust_moments(correspondences_->view(), best_.pose, {.scale = noise_bound_, .cutoff = noise_bound_});
}

void BestPoses::promote(const PoseCandidate& candidate) {
  const PoseCandidate former = best_;
  set_best(candidate);
  if (same_motion_as_best(runner_up_.pose)) runner_up_ = {};
  if (!same_motion_as_best(former.pose)) runner_up_ = former;
}

bool BestPoses::offer(const PoseCandidate& candidate) {
  if (candidate.support.score <= best_.support.score) {
    if (candidate.support.score > runner_up_.support.score && !same_motion_as_best(candidate.pose)) {
      runner_up_ = candidate;
    }
    return false;
  }
  const PoseCandidate former = best_;
  set_best(candidate);
  if (same_motion_as_best(runner_up_.pose)) runner_up_ = {};
  if (former.support.score > runner_up_.support.score && !same_motion_as_best(former.pose)) runner_up_ = former;
  return true;
}

}  // namespace consimd::detail
