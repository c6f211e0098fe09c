#include <consimd/solvers/solver.hpp>

#include <stdexcept>
#include <string>
#include <utility>

#include <consimd/solvers/noise_bound.hpp>
#include <consimd/solvers/tcf.hpp>

#include "stage_clock.hpp"

namespace consimd {
namespace {

constexpr SolverInfo kInfos[] = {
    {"tcf",
     "two-stage consensus filtering with pruning, re-selection over all correspondences and a posterior-weighted fit"},
    {"tcf-published", "two-stage consensus filtering, algorithms 1 to 4 of the paper to the letter"},
};

}  // namespace

std::span<const SolverInfo> solvers() noexcept { return kInfos; }

Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                              const SolverOptions& options) {
  TcfOptions tcf;
  if (solver == "tcf-published") {
    tcf = TcfOptions::as_published(0.0, options.seed);
  } else if (solver != "tcf") {
    std::string known;
    for (const SolverInfo& info : kInfos) known.append(known.empty() ? "" : ", ").append(info.name);
    throw std::invalid_argument("solver is '" + std::string(solver) + "', expected one of: " + known);
  }
  tcf.seed = options.seed;
  if (options.noise_bound) {
    tcf.noise_bound = *options.noise_bound;
    return register_tcf(correspondences, tcf);
  }
  StageReport estimation{"noise_bound", correspondences.size(), 0, 0, 0.0};
  {
    const detail::StageClock clock(estimation.seconds);
    const NoiseBoundEstimate estimate = estimate_noise_bound(correspondences, options.seed);
    tcf.noise_bound = estimate.noise_bound;
    tcf.bounds_tried = estimate.bounds_tried;
  }
  Registration result = register_tcf(correspondences, tcf);
  estimation.output = result.inliers.size();
  estimation.iterations = tcf.bounds_tried;
  result.seconds += estimation.seconds;
  result.stages.insert(result.stages.begin(), std::move(estimation));
  return result;
}

}  // namespace consimd
