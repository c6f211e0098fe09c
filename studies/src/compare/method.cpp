#include <consimd/studies/method.hpp>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <consimd/solvers/one_point_ransac.hpp>
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/registry.hpp>
#include <consimd/solvers/sa_cauchy_irls.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/three_point_ransac.hpp>
#include <consimd/solvers/two_point_ransac.hpp>

#include "text/words.hpp"

namespace consimd::studies {
namespace {

constexpr std::string_view kFilterPrefix = "tcf+";
constexpr std::string_view kScalePrefix = "scale+";
constexpr std::string_view kScansPrefix = "scans+";
constexpr std::string_view kPlainRansacPrefix = "plain-ransac-";
// By the triangle inequality no sample of inliers has lengths that differ by more, in noise bounds.
constexpr double kHarmlessLengthTolerance = 2.0;

/// Names of stages from left to right; nothing if one is no stage.
std::optional<std::vector<std::string_view>> stages_of(std::string_view name) {
  std::vector<std::string_view> stages = text::split(name, '+');
  for (const std::string_view stage : stages) {
    if (stage != "1R" && stage != "2R" && stage != "3R" && stage != "IRLS") return std::nullopt;
  }
  return stages;
}

Outcome run_stages(const std::vector<std::string_view>& stages, const Correspondences& correspondences,
                   double noise_bound, std::uint64_t seed) {
  const double lengths = 2.0 * noise_bound;
  Outcome outcome{.status = "rows"};
  const auto start = std::chrono::steady_clock::now();
  outcome.kept.resize(correspondences.size());
  std::iota(outcome.kept.begin(), outcome.kept.end(), 0U);
  const auto found = [&](bool has_pose, const RigidTransform& working) {
    outcome.has_pose = has_pose;
    outcome.status = has_pose ? "pose" : "no_pose";
    outcome.T_target_source = has_pose ? to_caller_frame(working, correspondences) : RigidTransform::Identity();
  };
  for (const std::string_view stage : stages) {
    if (stage == "1R") {
      const Correspondences subset = correspondences.subset(outcome.kept);
      ConsensusSet set = one_point_ransac(subset, {.consistency_bound = lengths, .seed = seed});
      for (std::uint32_t& member : set.members) member = outcome.kept[member];
      outcome.kept = std::move(set.members);
    } else if (stage == "2R") {
      outcome.kept = two_point_ransac(correspondences, outcome.kept,
                                      {.consistency_bound = lengths, .angle_bound = lengths, .seed = seed})
                         .members;
    } else if (stage == "3R") {
      ThreePointResult result =
          three_point_ransac(correspondences, outcome.kept, {.noise_bound = noise_bound, .seed = seed});
      outcome.kept = std::move(result.consensus.members);
      found(outcome.kept.size() >= 3, result.pose);
    } else {
      IrlsResult result = sa_cauchy_irls(correspondences, outcome.kept, {.final_scale = noise_bound});
      outcome.kept = std::move(result.members);
      found(result.fit.determined(), result.fit.pose);
    }
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return outcome;
}

std::optional<std::uint32_t> plain_ransac_iterations(std::string_view name) {
  if (!name.starts_with(kPlainRansacPrefix)) return std::nullopt;
  name.remove_prefix(kPlainRansacPrefix.size());
  const auto iterations = text::number_in<std::uint32_t>(name);
  if (!iterations || *iterations == 0) {
    throw std::invalid_argument(fmt::format("'{}' is not a number of iterations", name));
  }
  return iterations;
}

}  // namespace

Outcome run_method(std::string_view name, const Correspondences& correspondences, double noise_bound,
                   std::uint64_t seed) {
  if (const auto iterations = plain_ransac_iterations(name)) {
    return outcome_of(register_ransac(correspondences, {.noise_bound = noise_bound,
                                                        .seed = seed,
                                                        .max_iterations = *iterations,
                                                        .confidence = std::nullopt,
                                                        .length_tolerance = kHarmlessLengthTolerance,
                                                        .local_optimisation = false}));
  }
  if (const auto stages = stages_of(name)) return run_stages(*stages, correspondences, noise_bound, seed);
  SolverOptions options{.noise_bound = noise_bound, .seed = seed};
  if (name.starts_with(kFilterPrefix)) {
    options.filter = Filter::tcf;
    name.remove_prefix(kFilterPrefix.size());
  } else if (name.starts_with(kScalePrefix)) {
    options.estimate_scale = true;
    name.remove_prefix(kScalePrefix.size());
  }
  return outcome_of(register_by_name(name, correspondences, options));
}

bool is_method_of_stages(std::string_view name) {
  return name.starts_with(kPlainRansacPrefix) || stages_of(name).has_value();
}

bool gives_rows_alone(std::string_view name) {
  const auto stages = stages_of(name);
  return stages &&
         std::ranges::none_of(*stages, [](std::string_view stage) { return stage == "3R" || stage == "IRLS"; });
}

std::optional<OutsideMethod> outside_method(const OutsideSolvers& outside, std::string_view name) {
  const bool filtered = name.starts_with(kFilterPrefix);
  if (filtered) name.remove_prefix(kFilterPrefix.size());
  const OutsideSolver* solver = find_outside(outside, name);
  if (solver == nullptr) return std::nullopt;
  return OutsideMethod{solver, filtered ? Filter::tcf : Filter::none};
}

std::optional<std::string_view> pipeline_solver(std::string_view name) noexcept {
  if (!name.starts_with(kScansPrefix)) return std::nullopt;
  return name.substr(kScansPrefix.size());
}

std::string option_values(std::string_view name) {
  if (plain_ransac_iterations(name) || stages_of(name)) return {};
  for (const std::string_view prefix : {kFilterPrefix, kScalePrefix, kScansPrefix}) {
    if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  }
  const SolverChoice choice(name);
  std::string values;
  for (const SolverOption& option : choice.solver().options) {
    values += fmt::format("{}={}\n", option.name, to_string(choice.value(option.name)));
  }
  return values;
}

std::string after_filter(std::string_view solver) { return fmt::format("{}{}", kFilterPrefix, solver); }

std::string with_scale(std::string_view solver) { return fmt::format("{}{}", kScalePrefix, solver); }

std::string from_scans(std::string_view solver) { return fmt::format("{}{}", kScansPrefix, solver); }

std::string plain_ransac(std::uint32_t iterations) { return fmt::format("{}{}", kPlainRansacPrefix, iterations); }

}  // namespace consimd::studies
