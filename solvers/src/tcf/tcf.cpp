#include <consimd/solvers/tcf.hpp>

#include <utility>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/solvers/ransac.hpp>

#include "ransac/three_point_search.hpp"
#include "sampling/sampling.hpp"
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

// log10 of false poses down to which a pose is in doubt, alone or beside a rival: three and ten times what success
// needs. And the share of the largest set below which its supporters are few among those that agree by other reasons.
constexpr double kInDoubt = 3.0 * detail::kSignificant;
constexpr double kInDoubtBesideRival = 10.0 * detail::kSignificant;
constexpr double kFewOfTheSet = 0.25;

// A pose and what it is worth.
struct Judged {
  detail::BestPoses poses;
  detail::FinalPose final;
};

bool are_rivals(const detail::PoseCandidate& runner_up, const detail::PoseCandidate& best) {
  return runner_up.support.count >= 3 && detail::is_rival(runner_up.support.count, best.support.count);
}

// The best poses of another search, as all rows see them, are held against what was found, and the most significant
// stays.
void hold_against(const detail::PoseCandidate& best, const detail::PoseCandidate& runner_up,
                  const Correspondences& correspondences, const detail::PoseTest& test, Judged& judged) {
  const detail::BestPoses former = judged.poses;
  for (const auto& [found, other] : {std::pair(best, runner_up), std::pair(runner_up, best)}) {
    if (found.support.count < 3) continue;
    detail::BestPoses poses = former;
    if (are_rivals(runner_up, best)) poses.promote(other);
    poses.promote(found);
    detail::FinalPose final = detail::finish(correspondences, test, poses);
    final.log10_false_poses += elementary::log10(kSearches);
    if (final.log10_false_poses >= judged.final.log10_false_poses) continue;
    final.was_runner_up = true;
    judged = {poses, final};
  }
}

// Keeps another motion that was met as the runner-up, where it has more support than that.
void keep_as_runner_up(const detail::PoseCandidate& met, detail::BestPoses& poses) {
  if (met.support.count < 3 || met.support.count <= poses.runner_up().support.count) return;
  if (poses.same_motion_as_best(met.pose)) return;
  const detail::PoseCandidate best = poses.best();
  poses.promote(met);
  poses.promote(best);
}

// The support of clusters outweighs that of a pose whose supporters are few but far apart. Among independent rows it
// does not. Looked for where what was found is not significant, or is the motion of few places that many rows tell of.
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
    return found.support.count < 3 ? found : detail::scored(view, found.pose, test.noise_bound);
  };
  hold_against(among_all(search.poses().best()), among_all(search.poses().runner_up()), correspondences, test, judged);
}

// Where many pairs agree because matches keep range and height, those of such matches agree with more of a set than the
// true ones, which pruning then leaves out. Two motions with about the same support are a sign of it, and support that
// is hardly more than such matches explain. Triples of all rows do not know of sets; looked at only where few are
// enough. The search's largest set tells whether other reasons make rows agree. Returns the triples drawn; `stopped` is
// set where the options' condition ended this.
std::uint64_t search_triples(const Correspondences& correspondences, const TcfOptions& options,
                             const detail::PoseTest& test, std::size_t largest_set, Judged& judged, bool& stopped) {
  constexpr std::uint32_t kMostTriples = 65'536;
  const detail::PoseCandidate& best = judged.poses.best();
  if (best.support.count < 3) return 0;
  if (best.support.count > kFewOfTheSet * static_cast<double>(largest_set)) return 0;
  const bool has_rival = are_rivals(judged.poses.runner_up(), best);
  if (judged.final.log10_false_poses < (has_rival ? kInDoubtBesideRival : kInDoubt)) return 0;
  const double share = best.support.count / static_cast<double>(correspondences.size());
  if (detail::iterations_needed(options.confidence, share, 3) > kMostTriples) return 0;
  const RansacOptions ransac{.noise_bound = options.noise_bound,
                             .seed = options.seed,
                             .max_iterations = kMostTriples,
                             .confidence = options.confidence,
                             .stop = options.stop};
  detail::ThreePointSearch search(correspondences, ransac);
  search.run();
  const detail::PoseCandidate& met = search.poses().best();
  const detail::PoseCandidate& other = search.poses().runner_up();
  if (met.support.count > best.support.count && !judged.poses.same_motion_as_best(met.pose)) {
    hold_against(met, other, correspondences, test, judged);
  }
  keep_as_runner_up(met, judged.poses);
  keep_as_runner_up(other, judged.poses);
  stopped = stopped || search.stopped();
  return search.iterations();
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
  double triples_seconds = 0.0;
  std::uint64_t triples = 0;
  if (!search.stopped() && !result.stopped) {
    const detail::StageClock triples_clock(triples_seconds);
    triples = search_triples(correspondences, options, test, search.sets().largest_raw_set(), judged, result.stopped);
  }
  const auto& [poses, final] = judged;
  result.stopped = result.stopped || search.stopped();

  detail::conclude(correspondences, test, poses, search.best_set(), final, search.confident(), result);
  const detail::SeedSets& sets = search.sets();
  result.stages = {
      {"one_point", size, sets.largest_raw_set(), sets.drawn(), sets.one_point_seconds()},
      {"two_point", sets.largest_raw_set(), search.best_set().size(), search.seeds(), search.two_point_seconds()},
      {"three_point", size, poses.best().support.count, search.minimal_fits() + triples,
       search.three_point_seconds() + triples_seconds},
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
