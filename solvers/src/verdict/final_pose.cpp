#include "verdict/final_pose.hpp"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include <consimd/solvers/pose_refinement.hpp>

#include "call/stage_clock.hpp"
#include "search/consensus_search.hpp"
#include "verdict/chance_search.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd::detail {
namespace {

// Of a residual per axis, where it is not estimated: the noise bound is three of them.
constexpr double kSigmaPerBound = 1.0 / 3.0;

// Whether a pose with so many supporters might be the true one as well.
bool is_rival(std::size_t support, const BestPoses& poses) {
  return static_cast<double>(support) >= kRivalShare * poses.best().support.count;
}

// The runner-up, brought into place like the best pose was; none if it is no other motion then.
std::optional<RunnerUp> runner_up(const Correspondences& correspondences, const TcfOptions& options,
                                  const BestPoses& poses) {
  if (poses.runner_up().support.count < 3) return std::nullopt;
  const PoseCandidate rival = locally_optimise(correspondences, poses.runner_up(), options.noise_bound);
  if (poses.same_motion_as_best(rival.pose)) return std::nullopt;
  const Scrutiny scrutiny = is_rival(rival.support.count, poses) ? Scrutiny::close : Scrutiny::glance;
  return RunnerUp{
      to_caller_frame(from_working_pose(rival.pose), correspondences), rival.support.count,
      significance(correspondences, rival.pose, options.noise_bound, options.seed, scrutiny).log10_false_poses};
}

}  // namespace

Registration start_registration(double noise_bound, std::uint64_t seed) {
  Registration result;
  result.seed = seed;
  result.isa = active_isa();
  result.threads = tbb::this_task_arena::max_concurrency();
  result.noise_bound = noise_bound;
  result.consistency_bound = 2.0 * noise_bound;
  return result;
}

FinalPose finish(const Correspondences& correspondences, const TcfOptions& options, const PoseCandidate& best,
                 std::uint32_t seeds, Refinement refinement, const std::optional<Significance>& glance) {
  const CorrespondenceView view = correspondences.view();
  const double tau = options.noise_bound;
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
      glance ? *glance : significance(correspondences, best.pose, options.noise_bound, options.seed);
  final.log10_false_poses = log10_false_poses(correspondences, options, best, seeds, closed_form) +
                            std::log10(std::max(options.bounds_tried, 1U));
  return final;
}

void conclude(const Correspondences& correspondences, const TcfOptions& options, const BestPoses& poses,
              const std::vector<std::uint32_t>& set, const FinalPose& final, bool confident, Registration& result) {
  result.log10_false_poses = final.log10_false_poses;
  if (final.inliers.size() < 3 ? coincident_or_collinear(correspondences)
                               : final.rotation_deviation > kLargestRotationDeviation) {
    result.status = Status::degenerate_geometry;
  } else if (final.log10_false_poses >= kSignificant ||
             is_mirrored(correspondences, set, final.inliers.size(), options.noise_bound)) {
    result.status = Status::no_consensus;
  } else {
    result.runner_up = runner_up(correspondences, options, poses);
    const bool ambiguous = result.runner_up && is_rival(result.runner_up->support, poses) &&
                           result.runner_up->log10_false_poses < kSignificant;
    result.status = ambiguous ? Status::ambiguous : confident ? Status::success : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.pose, correspondences);
    result.covariance = final.covariance;
    result.inliers = final.inliers;
  }
}

void finish_and_conclude(const Correspondences& correspondences, const TcfOptions& test_options, const BestPoses& poses,
                         const std::vector<std::uint32_t>& set, bool confident, Registration& result) {
  const std::size_t size = correspondences.size();
  StageReport report{"irls", size};
  FinalPose final;
  if (poses.best().support.count >= 3) {
    const StageClock clock(report.seconds);
    final = finish(correspondences, test_options, poses.best(), static_cast<std::uint32_t>(size));
  }
  conclude(correspondences, test_options, poses, set, final, confident, result);
  report.output = result.inliers.size();
  report.iterations = final.rounds;
  result.stages.push_back(report);
}

}  // namespace consimd::detail
