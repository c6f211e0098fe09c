#include "scale/scaled_registration.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/scale_voting.hpp>

#include "call/solver_call.hpp"
#include "search/consensus_search.hpp"
#include "support/best_poses.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/another_scale.hpp"
#include "verdict/pairing_chances.hpp"

namespace consimd::detail {
namespace {

// Votes, as a share of the most, from which a scale is tried though another has a pose already.
constexpr double kRivalVotes = 0.3;
// Pairs whose lengths are compared to count scales.
constexpr std::uint32_t kPairs = 1024;
constexpr double kMostScales = 1e4;

/// Scales that pairs can tell apart: at each only a share of the mismatched pairs agree in length.
double scales_told_apart(const Correspondences& scaled, double noise_bound, std::uint64_t seed) {
  const LengthChance chance(scaled.view(), {}, kPairs, seed);
  return std::min(std::ceil(1.0 / std::max(chance(2.0 * noise_bound), 1e-9)), kMostScales);
}

std::uint32_t times(std::uint32_t bounds_tried, double scales) {
  return static_cast<std::uint32_t>(std::min(std::max(bounds_tried, 1U) * scales, 4e9));
}

/// What a scale led to.
struct Trial {
  Similarity similarity;
  Registration run;
};

/// The trial with most inliers; the first one if none has a pose.
std::size_t best_of(const std::vector<Trial>& trials) {
  std::size_t best = 0;
  for (std::size_t t = 1; t < trials.size(); ++t) {
    if (trials[t].run.inliers.size() > trials[best].run.inliers.size()) best = t;
  }
  return best;
}

/// The poses that other scales led to, the best of them first refined; none without one.
void add_rival(const std::vector<Trial>& trials, std::size_t best, Registration& result) {
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const Registration& run = trials[t].run;
    if (t == best || !run.has_pose()) continue;
    if (result.runner_up && result.runner_up->support >= run.inliers.size()) continue;
    result.runner_up =
        RunnerUp{run.T_target_source, run.inliers.size(), run.log10_false_poses, trials[t].similarity.scale};
    if (is_rival(run.inliers.size(), result.inliers.size())) result.status = Status::ambiguous;
  }
}

void solve(const Correspondences& correspondences, double noise_bound, std::uint32_t bounds_tried, std::uint64_t seed,
           Refinement refinement, const KnownScaleSolver& solver, Registration& result) {
  const std::size_t size = correspondences.size();
  StageReport voting{"scale_voting", size};
  std::vector<VotedScale> scales;
  {
    const StageClock stage_clock(voting.seconds);
    scales = scale_voting(correspondences, {.noise_bound = noise_bound, .seed = seed});
  }
  if (scales.empty()) scales.emplace_back();  // nothing tells: what the solver says of scale 1
  voting.output = scales.front().voters;
  voting.iterations = scales.front().measurements;
  result.stages = {voting};

  std::vector<Trial> trials;
  for (const VotedScale& voted : scales) {
    const bool found = !trials.empty() && trials[best_of(trials)].run.has_pose();
    if (found && voted.votes < kRivalVotes * scales.front().votes) break;
    const Correspondences scaled = correspondences.with_scaled_source(voted.scale);
    Trial trial{{voted.scale}, solver(scaled, times(bounds_tried, scales_told_apart(scaled, noise_bound, seed)))};
    trial.similarity.T_target_source = trial.run.T_target_source;
    std::ranges::copy(trial.run.stages, std::back_inserter(result.stages));
    result.stopped = result.stopped || trial.run.stopped;
    trials.push_back(std::move(trial));
  }
  const std::size_t best = best_of(trials);
  const Registration& found = trials[best].run;
  if (!found.has_pose()) {
    result.status = found.status;
    result.log10_false_poses = found.log10_false_poses;
    return;
  }

  StageReport similarity_report{"similarity", size};
  {
    const StageClock stage_clock(similarity_report.seconds);
    Similarity similarity = trials[best].similarity;
    if (refinement == Refinement::full) {
      similarity_report.iterations = refine_similarity(correspondences, noise_bound, similarity);
    }
    const Correspondences scaled = correspondences.with_scaled_source(similarity.scale);
    const PoseTest test{noise_bound, times(bounds_tried, scales_told_apart(scaled, noise_bound, seed))};
    BestPoses poses(scaled, noise_bound);
    poses.offer(scored(scaled, similarity.T_target_source, noise_bound));
    if (found.runner_up) poses.offer(scored(scaled, found.runner_up->T_target_source, noise_bound));
    FinalPose final;
    if (poses.best().support.count >= 3) {
      final = finish(scaled, test, poses, refinement);
    }
    // The solver has told that the set is no reflection's.
    conclude(scaled, test, poses, final.inliers, final, found.status != Status::budget_exhausted, result);
    similarity_report.output = result.inliers.size();
    if (result.has_pose()) {
      result.scale = similarity.scale;
      result.scale_deviation = final.scale_deviation * similarity.scale;
      if (result.runner_up) result.runner_up->scale = similarity.scale;
      const Eigen::Vector3d lever =
          result.T_target_source.linear() * (Eigen::Vector3d(final.centre) / scaled.scale() +
                                             Eigen::Map<const Eigen::Vector3d>(scaled.source_centroid().data()));
      const Eigen::Vector3d shift = final.scale_deviation * lever;
      result.covariance.bottomRightCorner<3, 3>() += shift * shift.transpose();
      add_rival(trials, best, result);
    }
  }
  result.stages.push_back(similarity_report);
}

}  // namespace

Registration register_scaled(const Correspondences& correspondences, const CallOptions& options,
                             std::uint32_t bounds_tried, Refinement refinement, const KnownScaleSolver& solver) {
  return run_solver(correspondences, options,
                    [&](const Correspondences& rows, const CallOptions& used, Registration& result) {
                      solve(rows, used.noise_bound, bounds_tried, used.seed, refinement, solver, result);
                    });
}

}  // namespace consimd::detail
