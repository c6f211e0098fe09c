#include <consimd/solvers/tcf.hpp>

#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"
#include "search/consensus_search.hpp"
#include "tcf/tcf_published.hpp"
#include "verdict/chance_search.hpp"
#include "verdict/final_pose.hpp"

namespace consimd {

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
  Registration result = detail::start_registration(options.noise_bound, options.seed);
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

  detail::ConsensusSearch search(correspondences, options);
  double refinement_seconds = 0.0;
  detail::FinalPose final;
  for (const bool exhaustive : {false, true}) {
    search.run(exhaustive);
    const detail::StageClock refinement_clock(refinement_seconds);
    if (search.best().support.count >= 3)
      final = detail::finish(correspondences, options, search.best(), search.sets().drawn(), detail::Refinement::full,
                             search.settled());
    if (final.log10_false_poses < detail::kSignificant) break;
  }

  detail::conclude(correspondences, options, search.poses(), search.best_set(), final, search.confident(), result);
  const detail::SeedSets& sets = search.sets();
  result.stages = {
      {"one_point", size, sets.largest_raw_set(), sets.drawn(), sets.one_point_seconds()},
      {"two_point", sets.largest_raw_set(), search.best_set().size(), sets.drawn(), sets.two_point_seconds()},
      {"three_point", size, search.best().support.count, search.minimal_fits(), search.three_point_seconds()},
      {"irls", size, result.inliers.size(), final.rounds, refinement_seconds}};
  return result;
}

}  // namespace consimd
