#include <consimd/solvers/solver.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <consimd/solvers/mac.hpp>
#include <consimd/solvers/noise_bound.hpp>
#include <consimd/solvers/pcr99.hpp>
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/sc2_pcr.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/tcf_published.hpp>
#include <consimd/solvers/teaser.hpp>
#include <consimd/solvers/turboreg.hpp>

#include "call/stage_clock.hpp"
#include "registry/filtered_registration.hpp"

namespace consimd {
namespace {

constexpr SolverInfo kInfos[] = {
    {"tcf",
     "two-stage consensus filtering with pruning, re-selection over all correspondences and a posterior-weighted fit"},
    {"tcf-published", "two-stage consensus filtering, algorithms 1 to 4 of the paper to the letter"},
    {"ransac", "three-point RANSAC with length check and local optimisation: at most 50 000 samples"},
    {"ransac-10k", "the same with 10 000 samples, never fewer"},
    {"ransac-50k", "the same with 50 000 samples, never fewer"},
    {"sc2_pcr", "second-order spatial compatibility: consensus sets of confident seeds"},
    {"turboreg", "three-cliques of the edges with most common neighbours"},
    {"pcr99", "triples in the order of how well their pairs agree in length with all others; known or unknown scale",
     true},
    {"teaser",
     "maximum clique of pairs that agree in length, rotation by graduated non-convexity, translation by votes; known "
     "or "
     "unknown scale",
     true},
    {"mac", "poses of the heaviest maximal cliques of compatible correspondences, the best by its score on all"},
};

Registration run_on(std::string_view solver, const Correspondences& correspondences, double noise_bound,
                    std::uint32_t bounds_tried, const SolverOptions& asked) {
  const std::uint64_t seed = asked.seed;
  if (solver.starts_with("ransac")) {
    RansacOptions options{.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried};
    if (solver != "ransac") {
      options.max_iterations = solver == "ransac-10k" ? 10'000 : 50'000;
      options.confidence.reset();
    }
    return register_ransac(correspondences, options);
  }
  if (solver == "sc2_pcr") {
    return register_sc2_pcr(correspondences, {.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried});
  }
  if (solver == "turboreg") {
    return register_turboreg(correspondences, {.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried});
  }
  if (solver == "pcr99") {
    return register_pcr99(correspondences, {.noise_bound = noise_bound,
                                            .seed = seed,
                                            .estimate_scale = asked.estimate_scale,
                                            .bounds_tried = bounds_tried});
  }
  if (solver == "teaser") {
    return register_teaser(correspondences, {.noise_bound = noise_bound,
                                             .seed = seed,
                                             .estimate_scale = asked.estimate_scale,
                                             .bounds_tried = bounds_tried});
  }
  if (solver == "mac") {
    return register_mac(correspondences, {.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried});
  }
  if (solver == "tcf-published") {
    return register_tcf_published(correspondences, {.noise_bound = noise_bound, .seed = seed});
  }
  return register_tcf(correspondences, {.noise_bound = noise_bound, .seed = seed, .bounds_tried = bounds_tried});
}

constexpr Filter kFilters[] = {Filter::none, Filter::tcf};

Registration run(const SolverCall& solver, const Correspondences& correspondences, double noise_bound,
                 std::uint32_t bounds_tried, const SolverOptions& options) {
  const auto solve = [&](const Correspondences& rows) { return solver(rows, noise_bound, bounds_tried); };
  if (options.filter == Filter::none) return solve(correspondences);
  return detail::register_filtered(correspondences, noise_bound, bounds_tried, options.seed, solve);
}

}  // namespace

std::string_view to_string(Filter filter) noexcept { return filter == Filter::tcf ? "tcf" : "none"; }

Filter filter_by_name(std::string_view name) {
  std::string known;
  for (const Filter filter : kFilters) {
    if (to_string(filter) == name) return filter;
    known.append(known.empty() ? "" : ", ").append(to_string(filter));
  }
  throw std::invalid_argument("filter is '" + std::string(name) + "', expected one of: " + known);
}

namespace {

void require_scale_estimation(const SolverInfo& info) {
  if (info.estimates_scale) return;
  std::string able;
  for (const SolverInfo& other : kInfos) {
    if (other.estimates_scale) able.append(able.empty() ? "" : ", ").append(other.name);
  }
  throw std::invalid_argument("estimate_scale: solver '" + std::string(info.name) +
                              "' needs a known scale, expected one of: " + able);
}

void require_scale_can_be_estimated(const SolverOptions& options) {
  if (!options.noise_bound) throw std::invalid_argument("estimate_scale: needs a noise_bound");
  if (options.filter != Filter::none) {
    throw std::invalid_argument("estimate_scale: filter '" + std::string(to_string(options.filter)) +
                                "' needs a known scale, expected none");
  }
}

}  // namespace

std::span<const SolverInfo> solvers() noexcept { return kInfos; }

Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                              const SolverOptions& options) {
  const auto info = std::ranges::find(kInfos, solver, &SolverInfo::name);
  if (info == std::end(kInfos)) {
    std::string known;
    for (const SolverInfo& other : kInfos) known.append(known.empty() ? "" : ", ").append(other.name);
    throw std::invalid_argument("solver is '" + std::string(solver) + "', expected one of: " + known);
  }
  if (options.estimate_scale) require_scale_estimation(*info);
  return register_with(
      [&](const Correspondences& rows, double noise_bound, std::uint32_t bounds_tried) {
        return run_on(solver, rows, noise_bound, bounds_tried, options);
      },
      correspondences, options);
}

Registration register_with(const SolverCall& solver, const Correspondences& correspondences,
                           const SolverOptions& options) {
  if (options.estimate_scale) require_scale_can_be_estimated(options);
  if (options.noise_bound) return run(solver, correspondences, *options.noise_bound, 1, options);
  StageReport estimation{"noise_bound", correspondences.size(), 0, 0, 0.0};
  NoiseBoundEstimate estimate;
  {
    const detail::StageClock clock(estimation.seconds);
    estimate = estimate_noise_bound(correspondences, options.seed);
  }
  Registration result = run(solver, correspondences, estimate.noise_bound, estimate.bounds_tried, options);
  estimation.output = result.inliers.size();
  estimation.iterations = estimate.bounds_tried;
  result.seconds += estimation.seconds;
  result.stages.insert(result.stages.begin(), std::move(estimation));
  return result;
}

}  // namespace consimd
