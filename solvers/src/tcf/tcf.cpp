#include <consimd/solvers/tcf.hpp>

#include "call/solver_call.hpp"
#include "search/consensus_search.hpp"
#include "tcf/tcf_options.hpp"
#include "tcf/tuned_tcf.hpp"
#include "verdict/final_pose.hpp"

namespace consimd {
namespace {

void solve(const Correspondences& correspondences, const TcfOptions& options, const detail::TcfTuning& tuning,
           Registration& result) {
  const std::size_t size = correspondences.size();
  const detail::ConsensusSearchOptions search_options{.noise_bound = options.noise_bound,
                                                      .seed = options.seed,
                                                      .confidence = options.confidence,
                                                      .max_seeds = options.max_seeds,
                                                      .matrix_budget_bytes = options.matrix_budget_bytes,
                                                      .tuning = tuning};
  const detail::PoseTest test = {options.noise_bound, options.bounds_tried};
  detail::ConsensusSearch search(correspondences, search_options);
  double refinement_seconds = 0.0;
  detail::BestPoses poses(correspondences, options.noise_bound);
  detail::FinalPose final;
  for (const bool exhaustive : {false, true}) {
    search.run(exhaustive);
    const detail::StageClock refinement_clock(refinement_seconds);
    if (search.best().support.count >= 3) {
      poses = search.poses();
      final = detail::finish(correspondences, test, poses, detail::Refinement::full, search.settled());
    }
    if (final.log10_false_poses < detail::kSignificant) break;
  }

  detail::conclude(correspondences, test, poses, search.best_set(), final, search.confident(), result);
  const detail::SeedSets& sets = search.sets();
  result.stages = {
      {"one_point", size, sets.largest_raw_set(), sets.drawn(), sets.one_point_seconds()},
      {"two_point", sets.largest_raw_set(), search.best_set().size(), sets.drawn(), sets.two_point_seconds()},
      {"three_point", size, poses.best().support.count, search.minimal_fits(), search.three_point_seconds()},
      {"refinement", size, result.inliers.size(), final.rounds, refinement_seconds}};
}

}  // namespace

Registration detail::register_tuned_tcf(const Correspondences& correspondences, const TcfOptions& options,
                                        const TcfTuning& tuning) {
  require_options(tcf_options(), options);
  return run_solver(correspondences, options,
                    [&](const Correspondences& rows, const TcfOptions& used, Registration& result) {
                      solve(rows, used, tuning, result);
                    });
}

Registration register_tcf(const Correspondences& correspondences, const TcfOptions& options) {
  return detail::register_tuned_tcf(correspondences, options, {});
}

}  // namespace consimd
