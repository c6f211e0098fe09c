#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>

#include "call/distinct_rows.hpp"
#include "call/refusal.hpp"
#include "noise_bound/bound_attempts.hpp"
#include "noise_bound/bound_search.hpp"
#include "noise_bound/measured_bound.hpp"
#include "search/consensus_search.hpp"
#include "support/independent_rows.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

// Once among all rows and once among those that stand for them.
constexpr std::uint32_t kSearches = 2;

double penalty_of_both() { return elementary::log10(kSearches * kBounds); }

}  // namespace

IndependentRows search_independent_bound(const Correspondences& correspondences, std::uint64_t seed,
                                         const StopCondition& stop) {
  IndependentRows result{{}, {1.0, 0.0, kSearches * kBounds}};
  const double largest_bound = largest_bound_of(DistinctRows(correspondences).correspondences());
  double least = kSignificant - penalty_of_both();
  for (std::uint32_t b = 0; b < kBounds && largest_bound > 0.0 && !stop.met(); ++b) {
    const double bound = std::ldexp(largest_bound, -static_cast<int>(b));
    std::vector<std::uint32_t> rows = rows_for_another_search(correspondences.view(), bound);
    // Among more a search of all rows loses nothing by what recurs, and a look takes long.
    if (rows.empty() || rows.size() > kFewRows) continue;
    const Correspondences independent = correspondences.subset(rows);
    ConsensusSearch search(independent,
                           {.noise_bound = bound, .seed = seed, .max_seeds = kSeeds, .stop = stop, .settles = false});
    search.run(false);
    CloseLooks looks(independent);
    for (const PoseCandidate* found : {&search.poses().best(), &search.poses().runner_up()}) {
      if (found->support.count < 3) continue;
      Attempt attempt = brought_to(independent, {bound, found->pose}, bound);
      attempt.log10_false_poses = looks.log10_false_poses(attempt.pose, bound);
      if (attempt.log10_false_poses >= least) continue;
      least = attempt.log10_false_poses;
      result.estimate.noise_bound = measured_bound(independent, looks, attempt);
      result.estimate.log10_false_poses = least + penalty_of_both();
      result.rows = rows;
    }
  }
  return result;
}

void bring_to_all_rows(const Correspondences& correspondences, std::uint32_t tries, Registration& result) {
  if (!result.has_pose()) return;
  const auto supporters = [&](const RigidTransform& T_target_source) {
    return pose_inliers(correspondences.view(), to_working_pose(to_working_frame(T_target_source, correspondences)),
                        result.noise_bound);
  };
  // What matchers keep shows the better the more rows there are.
  const DistinctRows rows(correspondences);
  const WorkingPose pose = to_working_pose(to_working_frame(result.T_target_source, correspondences));
  const double left = CloseLooks(rows.correspondences()).log10_false_poses(pose, result.noise_bound);
  if (left + elementary::log10(tries) >= 0.0) {
    refuse(result);
    return;
  }
  result.inliers = supporters(result.T_target_source);
  if (result.runner_up) result.runner_up->support = supporters(result.runner_up->T_target_source).size();
}

}  // namespace consimd::detail
