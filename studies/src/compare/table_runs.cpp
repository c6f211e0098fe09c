#include <consimd/studies/table_runs.hpp>

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/solvers/registry.hpp>

#include <consimd/studies/method.hpp>
#include "compare/table_methods.hpp"

namespace consimd::studies {
using namespace detail;
namespace {

constexpr double kIterationSigma = 1.0;

constexpr double kScaleOutliers = 0.9;
constexpr std::array kScaleSigmas{0.1, 1.0, 2.5, 5.0};

}  // namespace

bool detail::finds_scale(const TableOptions& options, std::string_view solver) {
  return find_outside(options.outside, solver) == nullptr && SolverChoice(solver).solver().estimates_scale();
}

std::vector<std::string> methods_of(const TableOptions& options) {
  std::vector<std::string> methods;
  const auto add = [&](std::string_view method) {
    if (std::ranges::find(methods, method) == methods.end()) methods.emplace_back(method);
  };
  if (wanted(options, "data")) add(kInputStage);
  for (const std::string& solver : options.solvers) {
    if (wanted(options, "boost") || (wants_solvers(options) && !options.filtered)) add(solver);
    if (wanted(options, "boost") || (wants_solvers(options) && options.filtered)) add(after_filter(solver));
  }
  if (wanted(options, "boost")) add(kFilterStages);
  if (wanted(options, "stages")) std::ranges::for_each(kStages, add);
  if (wanted(options, "poses")) std::ranges::for_each(kPoses, add);
  return methods;
}

std::vector<std::string> scan_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "pipeline")) return methods;
  for (const std::string& solver : options.solvers) {
    if (find_outside(options.outside, solver) == nullptr) methods.push_back(from_scans(solver));
  }
  return methods;
}

std::vector<std::string> iteration_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "iterations")) return methods;
  for (const std::uint32_t n : options.iterations) methods.push_back(plain_ransac(n));
  methods.emplace_back(kIterationRival);
  return methods;
}

std::vector<std::string> scale_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "scales")) return methods;
  for (const std::string& solver : options.solvers) {
    if (finds_scale(options, solver)) methods.push_back(with_scale(solver));
  }
  return methods;
}

CaseGroup iteration_group(const TableOptions& options, std::uint32_t problems, std::uint64_t seed) {
  CaseGroup group =
      noise_groups(
          {.outlier_ratios = {kIterationOutliers}, .sigmas = {kIterationSigma}, .trials = problems, .seed = seed})
          .front();
  group.name = kIterationGroup;
  group.provenance += fmt::format(", sigma {:g} m", kIterationSigma);
  group.methods = iteration_methods(options);
  return group;
}

std::vector<CaseGroup> scale_groups(const TableOptions& options, std::uint32_t trials, std::uint64_t seed) {
  std::vector<CaseGroup> groups;
  if (!wanted(options, "scales")) return groups;
  for (const double scale : options.scales) {
    CaseGroup group = noise_groups({.outlier_ratios = {kScaleOutliers},
                                    .sigmas = {kScaleSigmas.begin(), kScaleSigmas.end()},
                                    .trials = trials,
                                    .seed = seed,
                                    .scale = scale})
                          .front();
    group.name = scale_group_name(scale);
    group.provenance += fmt::format(", sigma {} m, source divided by the scale", fmt::join(kScaleSigmas, ", "));
    group.methods = scale_methods(options);
    groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace consimd::studies
