#include "support/best_poses.hpp"

#include "support/points.hpp"

namespace consimd::detail {
namespace {

constexpr double kExplained = 2.0;  // noise bounds within which a pose explains a row

}  // namespace

BestPoses::BestPoses(const Correspondences& correspondences, double noise_bound)
    : correspondences_(&correspondences), noise_bound_(noise_bound) {}

bool BestPoses::explains(const PoseCandidate& candidate, std::uint32_t row) const {
  const CorrespondenceView view = correspondences_->view();
  return candidate.support.count >= 3 && distance(moved(candidate.pose, source_point(view, row)),
                                                  target_point(view, row)) < kExplained * noise_bound_ * view.scale();
}

void BestPoses::set_best(const PoseCandidate& candidate) {
  best_ = candidate;
  best_motion_ = SupportedMotion(correspondences_->view(), best_.pose, noise_bound_);
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
