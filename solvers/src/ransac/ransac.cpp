#include <consimd/solvers/ransac.hpp>

#include "ransac/ransac_options.hpp"
#include "ransac/three_point_search.hpp"
#include "scale/rival_scale.hpp"
#include "search/consensus_search.hpp"
#include "verdict/final_pose.hpp"

namespace consimd {
namespace {

void solve(const Correspondences& correspondences, const RansacOptions& options, Registration& result) {
  StageReport search_report{"three_point", correspondences.size()};
  detail::ThreePointSearch search(correspondences, options);
  {
    const detail::StageClock search_clock(search_report.seconds);
    search.run();
  }
  search_report.output = search.poses().best().support.count;
  search_report.iterations = search.iterations();

  result.stages = {search_report};
  result.stopped = search.stopped();
  const detail::PoseTest test = {options.noise_bound, options.bounds_tried};
  detail::finish_and_conclude(correspondences, test, search.poses(), search.best_set(), search.confident(), result);
}

}  // namespace

Registration register_ransac(const Correspondences& correspondences, const RansacOptions& options) {
  detail::require_options(detail::ransac_options(), options);
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace consimd
