#include <consimd/studies/sweep_options.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/solvers/registry.hpp>

#include <consimd/studies/value_list.hpp>

namespace consimd::studies {
namespace {

constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::uint32_t kMostTrials = 1'000'000;

template <typename T>
void require_distinct(const std::vector<T>& values, std::string_view what) {
  if (values.empty()) throw std::invalid_argument(fmt::format("{}: at least one value is needed", what));
  for (auto value = values.begin(); value != values.end(); ++value) {
    if (std::find(values.begin(), value, *value) != value) {
      throw std::invalid_argument(fmt::format("{}: {} is given twice", what, *value));
    }
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
  require_distinct(options.outlier_ratios, "outliers");
  for (const double ratio : options.outlier_ratios) {
    if (!(ratio >= 0.0 && ratio < 1.0)) {
      throw std::invalid_argument(fmt::format("outliers: expected a ratio in [0, 1), got {}", ratio));
    }
    if (static_cast<double>(options.points) * (1.0 - ratio) < 2.5) {
      throw std::invalid_argument(
          fmt::format("outliers: a ratio of {} leaves fewer than 3 inliers among {} points", ratio, options.points));
    }
  }
  require_distinct(options.sigmas, "sigma");
  for (const double sigma : options.sigmas) {
    if (!(std::isfinite(sigma) && sigma > 0.0)) {
      throw std::invalid_argument(fmt::format("sigma: expected a finite length > 0 in metres, got {}", sigma));
    }
  }
  require_distinct(options.solvers, "solver");
  for (const std::string& solver : options.solvers) static_cast<void>(SolverChoice(solver));
}

}  // namespace consimd::studies
