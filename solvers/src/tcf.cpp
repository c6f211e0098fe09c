#include <consimd/solvers/tcf.hpp>

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "chance_search.hpp"
#include "consensus_search.hpp"
#include "option_checks.hpp"
#include "pose_checks.hpp"
#include "stage_clock.hpp"
#include "tcf_published.hpp"

namespace consimd {
namespace {

struct FinalPose {
  RigidTransform pose = RigidTransform::Identity();  // working frame
  std::vector<std::uint32_t> inliers;
  double rotation_deviation = 0.0;
  double log10_false_poses = 0.0;
  std::uint32_t rounds = 0;
  PoseCovariance covariance = PoseCovariance::Zero();
};

FinalPose finish(const Correspondences& correspondences, const TcfOptions& options, const detail::PoseCandidate& best,
                 std::uint32_t seeds) {
  const CorrespondenceView view = correspondences.view();
  const double tau = options.noise_bound;
  const RefinedPose refined = refine_pose(correspondences, best.pose, {tau});
  const WorkingPose pose = to_working_pose(refined.fit.pose);
  FinalPose final{refined.fit.pose,  detail::pose_inliers(view, pose, tau), 0.0, 0.0, refined.rounds,
                  refined.covariance};
  final.rotation_deviation = detail::rotation_deviation(view, pose, tau, refined.sigma);
  final.log10_false_poses =
      detail::log10_false_poses(correspondences, options, best, seeds) + std::log10(std::max(options.bounds_tried, 1U));
  return final;
}

// The runner-up, brought into place like the best pose was; none if it is no other motion then.
std::optional<RunnerUp> runner_up(const Correspondences& correspondences, const TcfOptions& options,
                                  const detail::BestPoses& poses) {
  if (poses.runner_up().support.count < 3) return std::nullopt;
  const detail::PoseCandidate rival = detail::locally_optimise(correspondences, poses.runner_up(), options.noise_bound);
  if (poses.same_motion_as_best(rival.pose)) return std::nullopt;
  return RunnerUp{to_caller_frame(from_working_pose(rival.pose), correspondences), rival.support.count,
                  significance(correspondences, rival.pose, options.noise_bound, options.seed).log10_false_poses};
}

// Whether the runner-up might as well be the true pose.
bool is_rival(const RunnerUp& runner_up, std::uint32_t best_support) {
  return static_cast<double>(runner_up.support) >= detail::kRivalShare * best_support &&
         runner_up.log10_false_poses < detail::kSignificant;
}

}  // namespace

TcfOptions TcfOptions::as_published(double noise_bound, std::uint64_t seed) {
  TcfOptions options;
  options.noise_bound = noise_bound;
  options.seed = seed;
  options.confidence = 0.99;
  options.published = true;
  return options;
}

Registration register_tcf(const Correspondences& correspondences, const TcfOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_confidence(options.confidence);
  Registration result;
  result.seed = options.seed;
  result.isa = active_isa();
  result.threads = tbb::this_task_arena::max_concurrency();
  result.noise_bound = options.noise_bound;
  result.consistency_bound = 2.0 * options.noise_bound;
  const detail::StageClock clock(result.seconds);
  const std::size_t size = correspondences.size();
  if (size < 3) {
    result.status = Status::too_few_correspondences;
    return result;
  }
  if (options.published) {
    detail::register_tcf_published(correspondences, options, result);
    return result;
  }

  detail::ConsensusSearch search(correspondences, options);
  double refinement_seconds = 0.0;
  FinalPose final;
  for (const bool exhaustive : {false, true}) {
    search.run(exhaustive);
    const detail::StageClock refinement_clock(refinement_seconds);
    if (search.best().support.count >= 3)
      final = finish(correspondences, options, search.best(), search.sets().drawn());
    if (final.log10_false_poses < detail::kSignificant) break;
  }

  result.log10_false_poses = final.log10_false_poses;
  if (final.inliers.size() < 3 ? detail::coincident_or_collinear(correspondences)
                               : final.rotation_deviation > detail::kLargestRotationDeviation) {
    result.status = Status::degenerate_geometry;
  } else if (final.log10_false_poses >= detail::kSignificant ||
             detail::is_mirrored(correspondences, search.best_set(), final.inliers.size(), options.noise_bound)) {
    result.status = Status::no_consensus;
  } else {
    result.runner_up = runner_up(correspondences, options, search.poses());
    result.status = result.runner_up && is_rival(*result.runner_up, search.best().support.count) ? Status::ambiguous
                    : search.confident()                                                         ? Status::success
                                         : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.pose, correspondences);
    result.covariance = final.covariance;
    result.inliers = std::move(final.inliers);
  }
  const detail::SeedSets& sets = search.sets();
  result.stages = {
      {"one_point", size, sets.largest_raw_set(), sets.drawn(), sets.one_point_seconds()},
      {"two_point", sets.largest_raw_set(), search.best_set().size(), sets.drawn(), sets.two_point_seconds()},
      {"three_point", size, search.best().support.count, search.minimal_fits(), search.three_point_seconds()},
      {"irls", size, result.inliers.size(), final.rounds, refinement_seconds}};
  return result;
}

}  // namespace consimd
