#include "registry/filtered_registration.hpp"

#include <iterator>
#include <span>
#include <utility>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/tcf_filter.hpp>

#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"
#include "support/best_poses.hpp"
#include "verdict/final_pose.hpp"

namespace consimd::detail {
namespace {

// A pose of the caller's frame with its support among all correspondences.
PoseCandidate candidate(const Correspondences& correspondences, const RigidTransform& T_target_source,
                        double noise_bound) {
  PoseCandidate result{to_working_pose(to_working_frame(T_target_source, correspondences)), {}};
  alignment_scores(correspondences, std::span(&result.pose, 1), noise_bound, std::span(&result.support, 1));
  return result;
}

}  // namespace

Registration register_filtered(const Correspondences& correspondences, double noise_bound, std::uint32_t bounds_tried,
                               std::uint64_t seed, const std::function<Registration(const Correspondences&)>& solver) {
  require_length("noise_bound", noise_bound);
  Registration result = start_registration(noise_bound, seed);
  const StageClock clock(result.seconds);
  const std::size_t size = correspondences.size();
  if (size < 3) {
    result.status = Status::too_few_correspondences;
    return result;
  }
  FilteredRows filtered = tcf_filter(correspondences, {.noise_bound = noise_bound, .seed = seed});
  result.stages = std::move(filtered.stages);
  Registration found = solver(correspondences.subset(filtered.rows));
  std::move(found.stages.begin(), found.stages.end(), std::back_inserter(result.stages));
  if (!found.has_pose()) {
    result.status = found.status == Status::too_few_correspondences ? Status::no_consensus : found.status;
    result.log10_false_poses = found.log10_false_poses;
    return result;
  }

  const TcfOptions options{.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried};
  StageReport all_rows{"all_rows", size};
  {
    const StageClock stage_clock(all_rows.seconds);
    BestPoses poses(correspondences, noise_bound);
    poses.offer(candidate(correspondences, found.T_target_source, noise_bound));
    if (found.runner_up) poses.offer(candidate(correspondences, found.runner_up->T_target_source, noise_bound));
    FinalPose final;
    if (poses.best().support.count >= 3) {
      final = finish(correspondences, options, poses.best(), static_cast<std::uint32_t>(size));
    }
    const bool confident = filtered.confident && found.status != Status::budget_exhausted;
    conclude(correspondences, options, poses, filtered.rows, final, confident, result);
    all_rows.iterations = final.rounds;
  }
  all_rows.output = result.inliers.size();
  result.stages.push_back(all_rows);
  return result;
}

}  // namespace consimd::detail
