#include <consimd/solvers/ransac.hpp>

#include "final_pose.hpp"
#include "option_checks.hpp"
#include "stage_clock.hpp"
#include "three_point_search.hpp"

namespace consimd {

Registration register_ransac(const Correspondences& correspondences, const RansacOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  if (options.confidence) detail::require_confidence(*options.confidence);
  if (!(options.length_tolerance > 0.0)) {
    detail::reject_option("length_tolerance", options.length_tolerance, "noise bounds above 0, or infinity");
  }
  Registration result = detail::start_registration(options.noise_bound, options.seed);
  const detail::StageClock clock(result.seconds);
  const std::size_t size = correspondences.size();
  if (size < 3) {
    result.status = Status::too_few_correspondences;
    return result;
  }
  StageReport search_report{"three_point", size};
  detail::ThreePointSearch search(correspondences, options);
  {
    const detail::StageClock search_clock(search_report.seconds);
    search.run();
  }
  const detail::PoseCandidate& best = search.poses().best();
  search_report.output = best.support.count;
  search_report.iterations = search.iterations();

  // Tested as if the default search had found it from all of its seeds, which finds poses of chance at least as well.
  const TcfOptions test_options{
      .noise_bound = options.noise_bound, .seed = options.seed, .bounds_tried = options.bounds_tried};
  StageReport refinement_report{"irls", size};
  detail::FinalPose final;
  if (best.support.count >= 3) {
    const detail::StageClock refinement_clock(refinement_report.seconds);
    final = detail::finish(correspondences, test_options, best, static_cast<std::uint32_t>(size));
  }
  detail::conclude(correspondences, test_options, search.poses(), search.best_set(), final, search.confident(), result);
  refinement_report.output = result.inliers.size();
  refinement_report.iterations = final.rounds;
  result.stages = {search_report, refinement_report};
  return result;
}

}  // namespace consimd
