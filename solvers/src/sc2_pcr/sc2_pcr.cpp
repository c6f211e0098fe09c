#include <consimd/solvers/sc2_pcr.hpp>

#include <cmath>
#include <string>
#include <utility>

#include "sc2_pcr/sc2_pcr_options.hpp"
#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "search/matrix_sample.hpp"
#include "support/hypothesis_selection.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd {
namespace {

void check(const Sc2PcrOptions& options) {
  detail::require_options(detail::sc2_pcr_options(), options);
  if (options.second_set > options.first_set) {
    detail::reject_option("second_set", options.second_set,
                          "no more than first_set, " + std::to_string(options.first_set));
  }
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
  // The rest of the correspondences are seeds as well if the first ones lead to no significant pose.
  for (const auto& [begin, end] : {std::pair(std::size_t{0}, first_seeds), std::pair(first_seeds, order.size())}) {
    const std::span<const std::uint32_t> seeds = std::span(order).subspan(begin, end - begin);
    {
      const detail::StageClock stage_clock(fitting.seconds);
      const SeedPoses hypotheses = second_order_poses(rows, matrices, seeds, options);
      result.stopped = hypotheses.stopped;
      if (const auto best = detail::select_pose(correspondences, hypotheses.poses, tau, options.ranking, poses)) {
        const IndexTriple& leading = hypotheses.leading[*best];
        best_set = detail::rows_agreeing_with(
            correspondences, {sample.row(leading.first), sample.row(leading.second), sample.row(leading.third)}, tau);
      }
      fitting.output = poses.best().support.count;
      fitting.iterations += seeds.size();
    }
    const detail::StageClock stage_clock(refinement.seconds);
    if (poses.best().support.count >= 3) {
      final = detail::finish(correspondences, test, poses);
    }
    if (final.log10_false_poses < detail::kSignificant || result.stopped) break;
  }
  detail::conclude(correspondences, test, poses, best_set, final, !result.stopped, result);
  seeding.output = fitting.iterations;
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
