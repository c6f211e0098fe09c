#include <consimd/studies/run_statistics.hpp>

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <consimd/solvers/registration.hpp>

namespace consimd::studies {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double ratio(double part, double whole) { return whole == 0.0 ? 0.0 : part / whole; }

template <typename Error>
ErrorStatistics error_statistics(const std::vector<RunRecord>& runs, Error error) {
  double sum = 0.0;
  double successes = 0.0;
  std::vector<double> all;
  for (const RunRecord& run : runs) {
    all.push_back(run.has_pose() ? error(run) : kInfinity);
    if (!run.success) continue;
    sum += error(run);
    successes += 1.0;
  }
  return {successes == 0.0 ? kNaN : sum / successes, median(std::move(all))};
}

/// Three significant digits at least, none of them an exponent.
std::string three_digits(double number) {
  if (!std::isfinite(number)) return "-";
  const int decimals = number >= 100.0 ? 0 : number >= 10.0 ? 1 : number >= 1.0 ? 2 : 3;
  return fmt::format("{:.{}f}", number, decimals);
}

}  // namespace

RunStatistics run_statistics(const std::vector<RunRecord>& runs) {
  const auto n = static_cast<double>(runs.size());
  std::size_t successes = 0, wrong = 0;
  std::vector<double> seconds;
  RunStatistics s{.largest_scale_error = kNaN};  // which std::fmax passes over
  for (const RunRecord& run : runs) {
    const auto rows = static_cast<double>(run.rows), inliers = static_cast<double>(run.inliers);
    const auto kept = static_cast<double>(run.kept), kept_inliers = static_cast<double>(run.kept_inliers);
    successes += run.success ? 1U : 0U;
    wrong += !run.success && run.status == to_string(Status::success) ? 1U : 0U;
    seconds.push_back(run.seconds);
    if (run.has_pose()) s.largest_scale_error = std::fmax(s.largest_scale_error, run.scale_error);
    s.rows += rows / n;
    s.inliers += inliers / n;
    s.inlier_ratio += ratio(inliers, rows) / n;
    s.kept += kept / n;
    s.kept_inliers += kept_inliers / n;
    s.kept_inlier_ratio += ratio(kept_inliers, kept) / n;
  }
  if (runs.empty()) {
    for (double* mean : {&s.rows, &s.inliers, &s.inlier_ratio, &s.kept, &s.kept_inliers, &s.kept_inlier_ratio}) {
      *mean = kNaN;
    }
  }
  s.recall = runs.empty() ? kNaN : static_cast<double>(successes) / n;
  s.wrong = runs.empty() ? kNaN : static_cast<double>(wrong) / n;
  s.recall_interval = wilson_interval(successes, runs.size());
  s.rotation_deg = error_statistics(runs, [](const RunRecord& run) { return run.rotation_error_deg; });
  s.translation = error_statistics(runs, [](const RunRecord& run) { return run.translation_error; });
  s.seconds_median = median(std::move(seconds));
  return s;
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:.1f}", 100.0 * share) : "-"; }

std::string fine_percent(double share) { return three_digits(100.0 * share); }

std::string interval(const Interval& shares) {
  return fmt::format("{:.1f} - {:.1f}", 100.0 * shares.low, 100.0 * shares.high);
}

std::string error(const ErrorStatistics& errors) {
  return fmt::format("{} ({})", three_digits(errors.mean_of_successes), three_digits(errors.median_of_all));
}

std::string milliseconds(double seconds) { return three_digits(1e3 * seconds); }

std::string metres(double length) { return std::isfinite(length) ? fmt::format("{:.2f}", length) : "-"; }

std::string count(double number) { return std::isfinite(number) ? fmt::format("{:.0f}", number) : "-"; }

}  // namespace consimd::studies
