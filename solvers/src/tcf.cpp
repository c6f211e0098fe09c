#include <consimd/solvers/tcf.hpp>

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "option_checks.hpp"
#include "sampling.hpp"
#include "seed_sets.hpp"
#include "set_poses.hpp"
#include "stage_clock.hpp"
#include "tcf_published.hpp"

namespace consimd {
namespace {

// Rounds of seeds grow from the first to the last size: few for easy problems, enough to keep many threads busy in hard
// ones.
constexpr std::uint32_t kFirstRound = 4;
constexpr std::uint32_t kLargestRound = 64;
// The sets tried first in a round; the others must promise more than what these gave.
constexpr std::size_t kFirstWave = 2;
// Sets and poses this much worse than the best of their round are not worth a fit.
constexpr float kWorthFitting = 0.5F;
constexpr float kWorthOptimising = 0.8F;
// A support is significant when less than a tenth of such a pose is expected by chance.
constexpr double kSignificant = -1.0;
// A rotation less certain than this, in radians, is not determined by the supporters.
constexpr double kLargestRotationDeviation = 0.35;
// Coordinates in the working frame are rounded to about this.
constexpr double kResolution = 1e-7;

struct Search {
  detail::PoseCandidate best;
  detail::SeedSets sets;
  double three_point_seconds = 0.0;
  std::uint64_t minimal_fits = 0;
  std::size_t set_size = 0;  // of the pruned set that the best pose came from
};

// Poses of the sets at `positions` of the round; the search's best is replaced when one is better.
void fit_sets(const Correspondences& correspondences, const TcfOptions& options,
              std::span<const std::uint32_t> positions, Search& search) {
  const detail::StageClock clock(search.three_point_seconds);
  std::size_t largest = 0;
  for (const std::uint32_t h : positions) largest = std::max(largest, search.sets.set(h).size());
  std::vector<std::uint32_t> fitted;
  for (const std::uint32_t h : positions) {
    const auto size = static_cast<float>(search.sets.set(h).size());
    if (size >= std::max(3.0F, kWorthFitting * static_cast<float>(largest))) fitted.push_back(h);
  }
  if (fitted.empty()) return;

  std::vector<detail::PoseCandidate> candidates(fitted.size());
  tbb::enumerable_thread_specific<detail::PoseScratch> scratch;
  const std::uint32_t round_start = search.sets.drawn();
  tbb::parallel_for(std::size_t{0}, fitted.size(), [&](std::size_t i) {
    candidates[i] = detail::pose_of_set(correspondences, search.sets.set(fitted[i]), options.noise_bound, options.seed,
                                        round_start + fitted[i], scratch.local());
  });
  search.minimal_fits += fitted.size() * detail::kTriplesPerSet;
  const auto winner = std::max_element(candidates.begin(), candidates.end(),
                                       [](const auto& a, const auto& b) { return a.support.score < b.support.score; });
  if (winner->support.score <= kWorthOptimising * search.best.support.score) return;
  const detail::PoseCandidate optimised = detail::locally_optimise(correspondences, *winner, options.noise_bound);
  if (optimised.support.score <= search.best.support.score) return;
  search.best = optimised;
  search.set_size = search.sets.set(fitted[static_cast<std::size_t>(winner - candidates.begin())]).size();
}

// Draws rounds of seeds until one of the best pose's supporters has been among them with the wanted confidence.
void run(const Correspondences& correspondences, const TcfOptions& options, bool exhaustive, Search& search) {
  const std::size_t size = correspondences.size();
  const auto limit = static_cast<std::uint32_t>(std::min<std::size_t>(size, options.max_seeds));
  const auto wanted = [&] {
    const std::uint32_t support = search.best.support.count;
    if (exhaustive || support < 3) return limit;
    const double share = static_cast<double>(support) / static_cast<double>(size);
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(limit, detail::iterations_needed(options.confidence, share, 1)));
  };
  for (std::uint32_t round = kFirstRound; search.sets.drawn() < wanted(); round = std::min(2 * round, kLargestRound)) {
    const std::uint32_t left = wanted() - search.sets.drawn();
    search.sets.draw(std::min(round, left), left > kLargestRound);
    std::span<const std::uint32_t> ranking = search.sets.rank(search.best.support.count);
    for (std::size_t wave = kFirstWave; !ranking.empty(); wave = ranking.size()) {
      wave = std::min(wave, ranking.size());
      search.sets.prune(ranking.first(wave), search.best.support.count);
      fit_sets(correspondences, options, ranking.first(wave), search);
      if (search.sets.drawn() >= wanted()) break;
      ranking = search.sets.promising(ranking.subspan(wave), search.best.support.count);
    }
  }
}

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
  constexpr double kEverything = 8.0;  // beyond every distance in the working frame
  const double bound = kEverything / correspondences.scale();
  const RigidMoments all = robust_moments(correspondences.view(), to_working_pose(RigidTransform::Identity()),
                                          {WeightFunction::truncated, bound, bound, 0.0});
  return rotation_deviation(all, kResolution) > kLargestRotationDeviation;
}

struct FinalPose {
  WorkingPose pose{};
  RigidTransform transform;
  std::vector<std::uint32_t> inliers;
  double rotation_deviation = 0.0;
  double log10_false_poses = 0.0;
  std::uint32_t rounds = 0;
};

FinalPose finish(const Correspondences& correspondences, const TcfOptions& options, const detail::PoseCandidate& best) {
  const CorrespondenceView view = correspondences.view();
  const RefinedPose refined = refine_pose(correspondences, best.pose, {options.noise_bound});
  FinalPose final{to_working_pose(refined.fit.pose), refined.fit.pose, {}, 0.0, 0.0, refined.rounds};
  final.inliers = detail::pose_inliers(view, final.pose, options.noise_bound);
  const RigidMoments moments =
      robust_moments(view, final.pose, {WeightFunction::truncated, options.noise_bound, options.noise_bound, 0.0});
  final.rotation_deviation = rotation_deviation(moments, std::max(refined.sigma * view.scale(), kResolution));
  final.log10_false_poses = log10_false_poses(correspondences, best.pose, options.noise_bound, options.seed);
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

  Search search{{},
                detail::SeedSets(correspondences, result.consistency_bound, options.seed, options.matrix_budget_bytes)};
  double refinement_seconds = 0.0;
  FinalPose final;
  for (const bool exhaustive : {false, true}) {
    run(correspondences, options, exhaustive, search);
    const detail::StageClock refinement_clock(refinement_seconds);
    if (search.best.support.count >= 3) final = finish(correspondences, options, search.best);
    if (final.log10_false_poses < kSignificant) break;
  }

  result.log10_false_poses = final.log10_false_poses;
  const bool significant = final.log10_false_poses < kSignificant;
  if (final.inliers.size() < 3 ? coincident_or_collinear(correspondences)
                               : final.rotation_deviation > kLargestRotationDeviation) {
    result.status = Status::degenerate_geometry;
  } else if (!significant) {
    result.status = Status::no_consensus;
  } else {
    const auto needed = detail::iterations_needed(
        options.confidence, static_cast<double>(search.best.support.count) / static_cast<double>(size), 1);
    const bool enough = search.sets.drawn() >= std::min<std::uint64_t>(needed, size);
    result.status = enough ? Status::success : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.transform, correspondences);
    result.inliers = std::move(final.inliers);
  }
  result.stages = {
      {"one_point", size, search.sets.largest_raw_set(), search.sets.drawn(), search.sets.one_point_seconds()},
      {"two_point", search.sets.largest_raw_set(), search.set_size, search.sets.drawn(),
       search.sets.two_point_seconds()},
      {"three_point", search.set_size, search.best.support.count, search.minimal_fits, search.three_point_seconds},
      {"irls", size, result.inliers.size(), final.rounds, refinement_seconds}};
  return result;
}

}  // namespace consimd
