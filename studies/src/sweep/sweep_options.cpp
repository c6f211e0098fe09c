#include <consimd/studies/sweep_options.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/synth/problem_families.hpp>

#include <consimd/studies/value_list.hpp>

namespace consimd::studies {
namespace {

constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::uint32_t kMostTrials = 1'000'000;
constexpr std::size_t kMostInAll = 1'000'000'000;  // trials: a bit of memory each
constexpr double kLargestSigma = 1e30;             // so that squares of errors are finite
constexpr double kLargestFactor = 1e6;             // every row of a problem is then within the bound

/// Values as messages show them.
template <typename T>
T shown(const T& value) {
  return value;
}
std::string_view shown(ScaleKnowledge scale) { return to_string(scale); }
std::string shown(const BoundFactor& factor) { return to_string(factor); }

template <typename T>
void require_any(const std::vector<T>& values, std::string_view what) {
  if (values.empty()) throw std::invalid_argument(fmt::format("{}: at least one value is needed", what));
}

/// The values must have an order: NaN is to be refused before.
template <typename T>
void require_distinct(const std::vector<T>& values, std::string_view what) {
  std::vector<T> sorted = values;
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
    throw std::invalid_argument(fmt::format("{}: {} is given twice", what, shown(*twice)));
  }
}

void require_unknown_scale_can_be_found(const SweepOptions& options) {
  for (const std::string& solver : options.solvers) {
    if (find_outside(options.outside, solver) != nullptr) {
      throw std::invalid_argument(
          fmt::format("scale unknown: solver {} is not consimd's, and is asked for rigid motions only", solver));
    }
    require_scale_estimation(SolverChoice(solver));
  }
  if (options.filter != Filter::none) {
    throw std::invalid_argument(
        fmt::format("scale unknown: filter '{}' goes by lengths, expected none", to_string(options.filter)));
  }
  if (std::ranges::find(options.bound_factors, BoundFactor()) != options.bound_factors.end()) {
    throw std::invalid_argument("scale unknown: a noise bound is needed, it cannot be estimated");
  }
}

/// What goes beyond the paper's study.
void require_conditions(const SweepOptions& options) {
  require_any(options.families, "family");
  for (const std::string& family : options.families) static_cast<void>(synth::problem_family(family));
  require_distinct(options.families, "family");
  require_any(options.scales, "scale");
  require_distinct(options.scales, "scale");
  require_any(options.bound_factors, "bound_factor");
  for (const BoundFactor& factor : options.bound_factors) {
    if (factor && !(*factor > 0.0 && *factor <= kLargestFactor)) {
      throw std::invalid_argument(
          fmt::format("bound_factor: expected a number above 0 and at most {}, got {}", kLargestFactor, *factor));
    }
  }
  require_distinct(options.bound_factors, "bound_factor");
  if (!(options.no_pose >= 0.0 && options.no_pose < 1.0)) {
    throw std::invalid_argument(fmt::format("no_pose: expected a share in [0, 1), got {}", options.no_pose));
  }
  if (std::ranges::find(options.scales, ScaleKnowledge::unknown) != options.scales.end()) {
    require_unknown_scale_can_be_found(options);
  }
}

}  // namespace

SweepOptions::SweepOptions()
    : outlier_ratios(parse_value_list(kPaperOutlierRatios)), sigmas(parse_value_list(kPaperSigmas)) {}

bool SweepOptions::beyond_paper() const {
  const Condition paper;
  return families != std::vector{paper.family} || scales != std::vector{paper.scale} || points.size() != 1 ||
         bound_factors != std::vector{paper.bound_factor} || no_pose != 0.0;
}

std::vector<Condition> SweepOptions::conditions() const {
  std::vector<Condition> all;
  for (const std::string& family : families) {
    for (const ScaleKnowledge scale : scales) {
      for (const std::size_t count : points) {
        for (const BoundFactor& factor : bound_factors) all.push_back({family, scale, count, factor});
      }
    }
  }
  return all;
}

bool SweepOptions::has_true_pose(std::uint32_t trial) const {
  // Of so many trials, so many have none: where their number grows by one, that trial is one of them.
  const auto without = [&](double of) { return std::floor(of * no_pose); };
  return without(trial + 1.0) == without(trial);
}

void validate(const SweepOptions& options) {
  require_any(options.points, "points");
  for (const std::size_t points : options.points) {
    if (points < 3 || points > kMostPoints) {
      throw std::invalid_argument(fmt::format("points: expected 3 to {}, got {}", kMostPoints, points));
    }
  }
  require_distinct(options.points, "points");
  if (options.trials < 1 || options.trials > kMostTrials) {
    throw std::invalid_argument(fmt::format("trials: expected 1 to {}, got {}", kMostTrials, options.trials));
  }
  require_any(options.outlier_ratios, "outliers");
  for (const double ratio : options.outlier_ratios) {
    if (!(ratio >= 0.0 && ratio < 1.0)) {
      throw std::invalid_argument(fmt::format("outliers: expected a ratio in [0, 1), got {}", ratio));
    }
    const std::size_t fewest = std::ranges::min(options.points);
    if (static_cast<double>(fewest) * (1.0 - ratio) < 2.5) {
      throw std::invalid_argument(
          fmt::format("outliers: a ratio of {} leaves fewer than 3 inliers among {} points", ratio, fewest));
    }
  }
  require_distinct(options.outlier_ratios, "outliers");
  require_any(options.sigmas, "sigma");
  for (const double sigma : options.sigmas) {
    if (!(sigma > 0.0 && sigma <= kLargestSigma)) {
      throw std::invalid_argument(
          fmt::format("sigma: expected a length above 0 and at most {} in metres, got {}", kLargestSigma, sigma));
    }
  }
  require_distinct(options.sigmas, "sigma");
  require_any(options.solvers, "solver");
  require_distinct(options.solvers, "solver");
  if (options.cells() > kMostInAll / options.trials) {
    throw std::invalid_argument(fmt::format("trials: expected at most {} in all, got {} in {} cells", kMostInAll,
                                            options.trials, options.cells()));
  }
  require_outside_solvers(options.outside, options.solvers);
  for (const std::string& solver : options.solvers) static_cast<void>(solver_label(options.outside, solver));
  require_conditions(options);
}

}  // namespace consimd::studies
