#include <consimd/solvers/sc2_pcr.hpp>

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sc2_pcr/sc2_pcr_options.hpp"
#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "search/matrix_sample.hpp"
#include "support/hypothesis_selection.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd {
namespace {

// A rival leads what the best pose leaves over: its rows agree with many more than those that agree by chance, and so
// they are the most confident ones. So few seeds meet it, and take little time beside the first ones.
constexpr std::size_t kRivalSeeds = 16;
// A seed's set is small, so that its pose is noisy and has half of the support that it has once it is in place.
constexpr double kPutInPlace = 2.0;

void check(const Sc2PcrOptions& options) {
  detail::require_options(detail::sc2_pcr_options(), options);
  if (options.second_set > options.first_set) {
    detail::reject_option("second_set", options.second_set,
                          "no more than first_set, " + std::to_string(options.first_set));
  }
}

// The most confident of the rows that `seeds` has and the best pose does not explain.
std::vector<std::uint32_t> rival_seeds(const detail::MatrixSample& sample, std::span<const std::uint32_t> seeds,
                                       const detail::BestPoses& poses) {
  std::vector<std::uint32_t> rivals;
  for (const std::uint32_t seed : seeds) {
    if (poses.best_explains(sample.row(seed))) continue;
    rivals.push_back(seed);
    if (rivals.size() == kRivalSeeds) break;
  }
  return rivals;
}

// Offers those of the poses that may be rivals. Returns the position of the last one that is the best pose now.
std::optional<std::size_t> offer_rivals(const Correspondences& correspondences, std::span<const WorkingPose> hypotheses,
                                        double noise_bound, detail::BestPoses& poses) {
  std::optional<std::size_t> best;
  for (std::size_t h = 0; h < hypotheses.size(); ++h) {
    const detail::PoseCandidate candidate = detail::scored(correspondences.view(), hypotheses[h], noise_bound);
    const double in_place = kPutInPlace * static_cast<double>(candidate.support.count);
    if (candidate.support.count < 3 ||
        in_place < detail::kRivalShare * static_cast<double>(poses.best().support.count) ||
        poses.same_motion_as_best(candidate.pose)) {
      continue;
    }
    if (poses.offer(detail::locally_optimise(correspondences, candidate, noise_bound))) best = h;
  }
  return best;
}

void solve(const Correspondences& correspondences, const Sc2PcrOptions& options, Registration& result) {
  const double tau = options.noise_bound;
  const std::size_t size = correspondences.size();
  StageReport compatibility{"compatibility", size};
  StageReport seeding{"seeds", size};
  StageReport fitting{"consensus_sets", size};
  StageReport refinement{"refinement", size};

  const detail::MatrixSample sample(correspondences, 2, options.matrix_budget_bytes, options.seed);
  const Correspondences& rows = sample.correspondences();
  CompatibilityMatrices matrices;
  {
    const detail::StageClock stage_clock(compatibility.seconds);
    matrices.compute(rows, options.length_tolerance * tau);
    compatibility.output = rows.size();
  }
  std::vector<std::uint32_t> order;
  {
    const detail::StageClock stage_clock(seeding.seconds);
    const std::vector<float> confidence = compatibility_confidence(matrices.loose, options.power_iterations);
    order = confidence_seeds(rows, confidence, options.seed_radius * tau, rows.size());
    seeding.input = rows.size();
  }
  const auto first_seeds = static_cast<std::size_t>(std::ceil(options.seed_share * static_cast<double>(rows.size())));
  detail::BestPoses poses(correspondences, tau);
  std::vector<std::uint32_t> best_set;
  const detail::PoseTest test = {tau, options.bounds_tried};
  detail::FinalPose final;
  const auto agreeing_with = [&](const IndexTriple& leading) {
    return detail::rows_agreeing_with(
        correspondences, {sample.row(leading.first), sample.row(leading.second), sample.row(leading.third)}, tau);
  };
  // The rest of the correspondences are seeds as well if the first ones lead to no significant pose.
  for (const auto& [begin, end] : {std::pair(std::size_t{0}, first_seeds), std::pair(first_seeds, order.size())}) {
    const std::span<const std::uint32_t> seeds = std::span(order).subspan(begin, end - begin);
    {
      const detail::StageClock stage_clock(fitting.seconds);
      const SeedPoses hypotheses = second_order_poses(rows, matrices, seeds, options);
      result.stopped = hypotheses.stopped;
      if (const auto best = detail::select_pose(correspondences, hypotheses.poses, tau, options.ranking, poses)) {
        best_set = agreeing_with(hypotheses.leading[*best]);
      }
      // Seeds are the rows of the motion that most rows agree on, and none may be of another one.
      if (begin == 0 && !result.stopped) {
        const std::vector<std::uint32_t> others = rival_seeds(sample, std::span(order).subspan(end), poses);
        const SeedPoses rivals = second_order_poses(rows, matrices, others, options);
        result.stopped = rivals.stopped;
        if (const auto best = offer_rivals(correspondences, rivals.poses, tau, poses)) {
          best_set = agreeing_with(rivals.leading[*best]);
        }
        fitting.iterations += others.size();
      }
      fitting.output = poses.best().support.count;
      fitting.iterations += seeds.size();
      seeding.output += seeds.size();
    }
    const detail::StageClock stage_clock(refinement.seconds);
    if (poses.best().support.count >= 3) {
      final = detail::finish(correspondences, test, poses);
    }
    if (final.log10_false_poses < detail::kSignificant || result.stopped) break;
  }
  detail::conclude(correspondences, test, poses, best_set, final, !result.stopped, result);
  refinement.output = result.inliers.size();
  refinement.iterations = final.rounds;
  result.stages = {compatibility, seeding, fitting, refinement};
}

}  // namespace

Registration register_sc2_pcr(const Correspondences& correspondences, const Sc2PcrOptions& options) {
  check(options);
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace consimd
