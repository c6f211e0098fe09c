#include <consimd/solvers/ransac.hpp>

#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"
#include "ransac/three_point_search.hpp"
#include "verdict/final_pose.hpp"

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
  search_report.output = search.poses().best().support.count;
  search_report.iterations = search.iterations();

  result.stages = {search_report};
  detail::finish_and_conclude(
      correspondences, {.noise_bound = options.noise_bound, .seed = options.seed, .bounds_tried = options.bounds_tried},
      search.poses(), search.best_set(), search.confident(), result);
  return result;
}

}  // namespace consimd
