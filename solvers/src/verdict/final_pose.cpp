#include "verdict/final_pose.hpp"

#include <algorithm>
#include <cmath>

#include <consimd/solvers/pose_refinement.hpp>

#include "call/stage_clock.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/chance_search.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd::detail {
namespace {

// The deviation of a residual per axis, where it is not estimated: the noise bound is three of them.
constexpr double kSigmaPerBound = 1.0 / 3.0;

// The runner-up, brought into place like the best pose was; none if it is no other motion then.
std::optional<RunnerUp> runner_up(const Correspondences& correspondences, const PoseTest& test,
                                  const BestPoses& poses) {
  if (poses.runner_up().support.count < 3) return std::nullopt;
  const PoseCandidate rival = locally_optimise(correspondences, poses.runner_up(), test.noise_bound);
  if (poses.same_motion_as_best(rival.pose)) return std::nullopt;
  const Scrutiny scrutiny =
      is_rival(rival.support.count, poses.best().support.count) ? Scrutiny::close : Scrutiny::glance;
  return RunnerUp{to_caller_frame(from_working_pose(rival.pose), correspondences), rival.support.count,
                  significance(correspondences, rival.pose, test.noise_bound, test.seed, scrutiny).log10_false_poses};
}

}  // namespace

FinalPose finish(const Correspondences& correspondences, const PoseTest& test, const PoseCandidate& best,
                 std::uint32_t seeds, Refinement refinement, const std::optional<Significance>& glance) {
  const CorrespondenceView view = correspondences.view();
  const double tau = test.noise_bound;
  RefinedPose refined;
  if (refinement == Refinement::full) {
    refined = refine_pose(correspondences, best.pose, {tau});
  } else {
    refined.fit.pose = from_working_pose(best.pose);
    refined.sigma = kSigmaPerBound * tau;
  }
  const WorkingPose pose = to_working_pose(refined.fit.pose);
  FinalPose final{.pose = refined.fit.pose,
                  .inliers = pose_inliers(view, pose, tau),
                  .rounds = refined.rounds,
                  .covariance = refined.covariance,
                  .scale_deviation = refined.scale_deviation,
                  .centre = refined.centre};
  final.rotation_deviation = rotation_deviation(view, pose, tau, refined.sigma);
  const Significance closed_form =
      glance ? *glance : significance(correspondences, best.pose, test.noise_bound, test.seed);
  final.log10_false_poses =
      log10_false_poses(correspondences, test, best, seeds, closed_form) + std::log10(std::max(test.bounds_tried, 1U));
  return final;
}

void conclude(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses,
              const std::vector<std::uint32_t>& set, const FinalPose& final, bool confident, Registration& result) {
  result.log10_false_poses = final.log10_false_poses;
  if (final.inliers.size() < 3 ? coincident_or_collinear(correspondences)
                               : final.rotation_deviation > kLargestRotationDeviation) {
    result.status = Status::degenerate_geometry;
  } else if (final.log10_false_poses >= kSignificant ||
             is_mirrored(correspondences, set, final.inliers.size(), test.noise_bound)) {
    result.status = Status::no_consensus;
  } else {
    result.runner_up = runner_up(correspondences, test, poses);
    const bool ambiguous = result.runner_up && is_rival(result.runner_up->support, poses.best().support.count) &&
                           result.runner_up->log10_false_poses < kSignificant;
    result.status = ambiguous ? Status::ambiguous : confident ? Status::success : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.pose, correspondences);
    result.covariance = final.covariance;
    result.inliers = final.inliers;
  }
}

void finish_and_conclude(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses,
                         const std::vector<std::uint32_t>& set, bool confident, Registration& result,
                         Refinement refinement) {
  const std::size_t size = correspondences.size();
  StageReport report{refinement == Refinement::full ? "refinement" : "significance", size};
  FinalPose final;
  if (poses.best().support.count >= 3) {
    const StageClock clock(report.seconds);
    final = finish(correspondences, test, poses.best(), static_cast<std::uint32_t>(size), refinement);
  }
  conclude(correspondences, test, poses, set, final, confident, result);
  report.output = result.inliers.size();
  report.iterations = final.rounds;
  result.stages.push_back(report);
}

}  // namespace consimd::detail
