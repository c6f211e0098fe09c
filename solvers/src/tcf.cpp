#include <consimd/solvers/tcf.hpp>

#include <Eigen/Eigenvalues>

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "consensus_search.hpp"
#include "option_checks.hpp"
#include "stage_clock.hpp"
#include "tcf_published.hpp"

namespace consimd {
namespace {

// log10 of the number of false poses below which a support is significant. From kSure to kHopeless the bound of the
// test alone does not decide, and the search is repeated on random pairings.
constexpr double kSignificant = -3.0;
constexpr double kSure = -6.0;
constexpr double kHopeless = 3.0;
// A rotation less certain than this, in radians, is not determined by the supporters.
constexpr double kLargestRotationDeviation = 0.35;
// Coordinates in the working frame are rounded to about this.
constexpr double kResolution = 1e-7;
// A length beyond every distance in the working frame.
constexpr double kEverything = 8.0;

// Standard deviation in radians of the rotation about its least certain axis, from the scatter of the supporters'
// sources.
double rotation_deviation(const RigidMoments& moments, double working_sigma) {
  const double* s = moments.source_scatter;
  const Eigen::Vector3d sum(moments.source[0], moments.source[1], moments.source[2]);
  Eigen::Matrix3d scatter;
  scatter << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
  scatter -= sum * sum.transpose() / moments.weight;
  const Eigen::Vector3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues();
  return working_sigma / std::sqrt(std::max(axes[0] + axes[1], 0.0));
}

bool coincident_or_collinear(const Correspondences& correspondences) {
  const double bound = kEverything / correspondences.scale();
  const RigidMoments all = robust_moments(correspondences.view(), to_working_pose(RigidTransform::Identity()),
                                          {WeightFunction::truncated, bound, bound, 0.0});
  return rotation_deviation(all, kResolution) > kLargestRotationDeviation;
}

// Whether a reflection aligns more of the set than the pose has supporters. The pairwise lengths that made the set one
// cannot tell a mirror image, of which a rotation fits whatever lies near a plane.
bool is_mirrored(const Correspondences& correspondences, const std::vector<std::uint32_t>& set, std::size_t supporters,
                 double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  std::vector<float> source;
  std::vector<float> target;
  for (const std::uint32_t row : set) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      source.push_back((axis == 0 ? -1.0F : 1.0F) * view.source(axis)[row]);
      target.push_back(view.target(axis)[row]);
    }
  }
  const Correspondences mirrored(PointSpan<float>::interleaved(source.data(), set.size()),
                                 PointSpan<float>::interleaved(target.data(), set.size()));
  const double bound = noise_bound * view.scale();  // the caller's unit is the working frame's here
  WorkingPose pose = to_working_pose(RigidTransform::Identity());
  for (const double cutoff : {kEverything, 4.0 * bound, 2.0 * bound, bound}) {
    const RigidFit fit = rigid_fit(robust_moments(mirrored.view(), pose, {.scale = cutoff, .cutoff = cutoff}));
    if (!fit.determined()) return false;
    pose = to_working_pose(fit.pose);
  }
  return detail::pose_inliers(mirrored.view(), pose, bound).size() > supporters;
}

struct FinalPose {
  RigidTransform pose = RigidTransform::Identity();  // working frame
  std::vector<std::uint32_t> inliers;
  double rotation_deviation = 0.0;
  double log10_false_poses = 0.0;
  std::uint32_t rounds = 0;
};

FinalPose finish(const Correspondences& correspondences, const TcfOptions& options, const detail::PoseCandidate& best) {
  const CorrespondenceView view = correspondences.view();
  const double tau = options.noise_bound;
  const RefinedPose refined = refine_pose(correspondences, best.pose, {tau});
  const WorkingPose pose = to_working_pose(refined.fit.pose);
  FinalPose final{refined.fit.pose, detail::pose_inliers(view, pose, tau), 0.0, 0.0, refined.rounds};
  final.rotation_deviation = rotation_deviation(robust_moments(view, pose, {.scale = tau, .cutoff = tau}),
                                                std::max(refined.sigma * view.scale(), kResolution));
  const Significance support = significance(correspondences, best.pose, tau, options.seed);
  final.log10_false_poses = support.log10_false_poses;
  if (support.log10_false_poses > kSure && support.log10_false_poses < kHopeless) {
    final.log10_false_poses =
        detail::log10_chance_of_score(correspondences, options, best.support.score * support.independent_share);
  }
  return final;
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
    if (search.best().support.count >= 3) final = finish(correspondences, options, search.best());
    if (final.log10_false_poses < kSignificant) break;
  }

  result.log10_false_poses = final.log10_false_poses;
  if (final.inliers.size() < 3 ? coincident_or_collinear(correspondences)
                               : final.rotation_deviation > kLargestRotationDeviation) {
    result.status = Status::degenerate_geometry;
  } else if (final.log10_false_poses >= kSignificant ||
             is_mirrored(correspondences, search.best_set(), final.inliers.size(), options.noise_bound)) {
    result.status = Status::no_consensus;
  } else {
    result.status = search.confident() ? Status::success : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.pose, correspondences);
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
