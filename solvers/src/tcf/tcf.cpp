#include <consimd/solvers/tcf.hpp>

#include <utility>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>

#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "support/independent_rows.hpp"
#include "support/pose_candidate.hpp"
#include "tcf/tcf_options.hpp"
#include "tcf/tuned_tcf.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/final_pose.hpp"

namespace consimd {
namespace {

// The better of two searches has had two tries at being significant.
constexpr double kSearches = 2.0;

// A pose and what it is worth.
struct Judged {
  detail::BestPoses poses;
  detail::FinalPose final;
};

// The support of clusters outweighs that of a pose whose supporters are few but far apart. Among independent rows it
// does not: the best poses of a search among them are held against what was found, and the most significant stays.
// Looked for where what was found is not significant, or is the motion of few places that many rows tell of.
void search_independent_rows(const Correspondences& correspondences, const detail::ConsensusSearchOptions& options,
                             const detail::PoseTest& test, Judged& judged) {
  const CorrespondenceView view = correspondences.view();
  if (judged.final.log10_false_poses < detail::kSignificant &&
      !detail::are_of_few_places(view, judged.final.inliers, test.noise_bound)) {
    return;
  }
  const std::vector<std::uint32_t> rows = detail::rows_for_another_search(view, test.noise_bound);
  if (rows.empty()) return;
  const Correspondences independent = correspondences.subset(rows);
  detail::ConsensusSearch search(independent, options);
  search.run(false);
  const auto among_all = [&](const detail::PoseCandidate& found) {
    return detail::scored(view, found.pose, test.noise_bound);
  };
  const detail::PoseCandidate& best = search.poses().best();
  const detail::PoseCandidate& runner_up = search.poses().runner_up();
  const bool are_rivals = runner_up.support.count >= 3 && detail::is_rival(runner_up.support.count, best.support.count);
  const detail::BestPoses former = judged.poses;
  for (const auto& [found, other] : {std::pair(best, runner_up), std::pair(runner_up, best)}) {
    if (found.support.count < 3) continue;
    detail::BestPoses poses = former;
    if (are_rivals) poses.promote(among_all(other));
    poses.promote(among_all(found));
    detail::FinalPose final = detail::finish(correspondences, test, poses);
    final.log10_false_poses += elementary::log10(kSearches);
    if (final.log10_false_poses >= judged.final.log10_false_poses) continue;
    final.was_runner_up = true;
    judged = {poses, final};
  }
}

void solve(const Correspondences& correspondences, const TcfOptions& options, const detail::TcfTuning& tuning,
           Registration& result) {
  const std::size_t size = correspondences.size();
  const detail::ConsensusSearchOptions search_options{.noise_bound = options.noise_bound,
                                                      .seed = options.seed,
                                                      .confidence = options.confidence,
                                                      .max_seeds = options.max_seeds,
                                                      .matrix_budget_bytes = options.matrix_budget_bytes,
                                                      .tuning = tuning,
                                                      .stop = options.stop};
  const detail::PoseTest test = {options.noise_bound, options.bounds_tried};
  detail::ConsensusSearch search(correspondences, search_options);
  double refinement_seconds = 0.0;
  Judged judged{detail::BestPoses(correspondences, options.noise_bound), {}};
  for (const bool careful : {false, true}) {
    if (careful && search.exhaustive()) break;
    if (careful && options.stop.met()) {
      result.stopped = true;
      break;
    }
    search.run(careful);
    const detail::StageClock refinement_clock(refinement_seconds);
    if (search.best().support.count < 3) continue;
    detail::BestPoses poses = search.poses();
    const detail::FinalPose final =
        detail::finish(correspondences, test, poses, detail::Refinement::full, search.settled());
    if (!careful || final.log10_false_poses < judged.final.log10_false_poses) judged = {poses, final};
    if (!careful && !search.stopped()) search_independent_rows(correspondences, search_options, test, judged);
    if (judged.final.log10_false_poses < detail::kSignificant) break;
  }
  const auto& [poses, final] = judged;
  result.stopped = result.stopped || search.stopped();

  detail::conclude(correspondences, test, poses, search.best_set(), final, search.confident(), result);
  const detail::SeedSets& sets = search.sets();
  result.stages = {
      {"one_point", size, sets.largest_raw_set(), sets.drawn(), sets.one_point_seconds()},
      {"two_point", sets.largest_raw_set(), search.best_set().size(), search.seeds(), search.two_point_seconds()},
      {"three_point", size, poses.best().support.count, search.minimal_fits(), search.three_point_seconds()},
      {"refinement", size, result.inliers.size(), final.rounds, refinement_seconds}};
}

}  // namespace

Registration detail::register_tuned_tcf(const Correspondences& correspondences, const TcfOptions& options,
                                        const TcfTuning& tuning) {
  require_options(tcf_options(), options);
  return run_at_known_scale(correspondences, options,
                            [&](const Correspondences& rows, const TcfOptions& used, Registration& result) {
                              solve(rows, used, tuning, result);
                            });
}

Registration register_tcf(const Correspondences& correspondences, const TcfOptions& options) {
  return detail::register_tuned_tcf(correspondences, options, {});
}

}  // namespace consimd
