#include <consimd/solvers/tcf_filter.hpp>

#include <utility>

#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/two_point_ransac.hpp>

#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"

namespace consimd {

FilteredRows tcf_filter(const Correspondences& correspondences, const TcfFilterOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_confidence(options.confidence);
  FilteredRows filtered;
  filtered.stages = {{"filter_one_point", correspondences.size()}, {"filter_two_point"}};
  StageReport& one_point = filtered.stages[0];
  StageReport& two_point = filtered.stages[1];
  ConsensusSet set;
  {
    const detail::StageClock clock(one_point.seconds);
    set = one_point_ransac(correspondences, {.consistency_bound = 2.0 * options.noise_bound,
                                             .confidence = options.confidence,
                                             .max_iterations = options.max_iterations,
                                             .seed = options.seed});
  }
  one_point.output = two_point.input = set.members.size();
  one_point.iterations = set.iterations;
  {
    const detail::StageClock clock(two_point.seconds);
    // The authors' angle bound: that of tau, as printed, turns inliers away.
    set = two_point_ransac(correspondences, set.members,
                           {.consistency_bound = 2.0 * options.noise_bound,
                            .angle_bound = 2.0 * options.noise_bound,
                            .confidence = options.confidence,
                            .max_iterations = options.max_iterations,
                            .seed = options.seed});
  }
  two_point.output = set.members.size();
  two_point.iterations = set.iterations;
  filtered.confident = one_point.iterations < options.max_iterations && two_point.iterations < options.max_iterations;
  filtered.rows = std::move(set.members);
  return filtered;
}

}  // namespace consimd
