#include <consimd/studies/sweep_options.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/studies/value_list.hpp>

namespace consimd::studies {
namespace {

constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::uint32_t kMostTrials = 1'000'000;
constexpr std::size_t kMostInAll = 1'000'000'000;  // trials: a bit of memory each
constexpr double kLargestSigma = 1e30;             // so that squares of errors are finite

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
    throw std::invalid_argument(fmt::format("{}: {} is given twice", what, *twice));
  }
}

}  // namespace

SweepOptions::SweepOptions()
    : outlier_ratios(parse_value_list(kPaperOutlierRatios)), sigmas(parse_value_list(kPaperSigmas)) {}

void validate(const SweepOptions& options) {
  if (options.points < 3 || options.points > kMostPoints) {
    throw std::invalid_argument(fmt::format("points: expected 3 to {}, got {}", kMostPoints, options.points));
  }
  if (options.trials < 1 || options.trials > kMostTrials) {
    throw std::invalid_argument(fmt::format("trials: expected 1 to {}, got {}", kMostTrials, options.trials));
  }
  require_any(options.outlier_ratios, "outliers");
  for (const double ratio : options.outlier_ratios) {
    if (!(ratio >= 0.0 && ratio < 1.0)) {
      throw std::invalid_argument(fmt::format("outliers: expected a ratio in [0, 1), got {}", ratio));
    }
    if (static_cast<double>(options.points) * (1.0 - ratio) < 2.5) {
      throw std::invalid_argument(
          fmt::format("outliers: a ratio of {} leaves fewer than 3 inliers among {} points", ratio, options.points));
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
}

}  // namespace consimd::studies
