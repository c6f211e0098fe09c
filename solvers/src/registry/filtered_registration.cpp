#include "registry/filtered_registration.hpp"

#include <iterator>
#include <utility>

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/tcf_filter.hpp>

#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "support/best_poses.hpp"
#include "verdict/final_pose.hpp"

namespace consimd::detail {
namespace {

void solve(const Correspondences& correspondences, double noise_bound, std::uint32_t bounds_tried, std::uint64_t seed,
           const std::function<Registration(const Correspondences&)>& solver, Registration& result) {
  const std::size_t size = correspondences.size();
  FilteredRows filtered = tcf_filter(correspondences, {.noise_bound = noise_bound, .seed = seed});
  result.stages = std::move(filtered.stages);
  Registration found = solver(correspondences.subset(filtered.rows));
  std::move(found.stages.begin(), found.stages.end(), std::back_inserter(result.stages));
  if (!found.has_pose()) {
    result.status = found.status == Status::too_few_correspondences ? Status::no_consensus : found.status;
    result.log10_false_poses = found.log10_false_poses;
    return;
  }

  const PoseTest test = {noise_bound, bounds_tried};
  StageReport all_rows{"all_rows", size};
  {
    const StageClock stage_clock(all_rows.seconds);
    BestPoses poses(correspondences, noise_bound);
    poses.offer(scored(correspondences, found.T_target_source, noise_bound));
    if (found.runner_up) poses.offer(scored(correspondences, found.runner_up->T_target_source, noise_bound));
    FinalPose final;
    if (poses.best().support.count >= 3) {
      final = finish(correspondences, test, poses);
    }
    const bool confident = filtered.confident && found.status != Status::budget_exhausted;
    conclude(correspondences, test, poses, filtered.rows, final, confident, result);
    all_rows.iterations = final.rounds;
  }
  all_rows.output = result.inliers.size();
  result.stages.push_back(all_rows);
}

}  // namespace

Registration register_filtered(const Correspondences& correspondences, double noise_bound, std::uint32_t bounds_tried,
                               std::uint64_t seed, const std::function<Registration(const Correspondences&)>& solver) {
  return run_at_known_scale(correspondences, CallOptions{noise_bound, seed},
                            [&](const Correspondences& rows, const CallOptions& used, Registration& result) {
                              solve(rows, used.noise_bound, bounds_tried, used.seed, solver, result);
                            });
}

}  // namespace consimd::detail
