// What the tables tell of a method's runs.
#pragma once

#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/run_record.hpp>
#include <consimd/studies/statistics.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// An error over several runs; NaN where there is none to take it over.
struct ErrorStatistics {
  double mean_of_successes = 0.0;
  double median_of_all = 0.0;  ///< a run without a pose counts as an infinite error
};

/// Over several runs; all NaN, and the interval [0, 1], without any.
struct RunStatistics {
  double recall = 0.0;
  Interval recall_interval = {};
  double wrong = 0.0;  ///< share of the runs that call a pose outside of the limits a success
  ErrorStatistics rotation_deg = {};
  ErrorStatistics translation = {};
  double seconds_median = 0.0;
  double largest_scale_error = 0.0;  ///< relative, of the runs with a pose
  // Means over the runs.
  double rows = 0.0;
  double inliers = 0.0;
  double inlier_ratio = 0.0;
  double kept = 0.0;
  double kept_inliers = 0.0;
  double kept_inlier_ratio = 0.0;  ///< of nothing kept: 0
};

[[nodiscard]] RunStatistics run_statistics(const std::vector<RunRecord>& runs);

/// Cells of a table; "-" for what is not a finite number.
[[nodiscard]] std::string percent(double share);
[[nodiscard]] std::string fine_percent(double share);
[[nodiscard]] std::string interval(const Interval& shares);
[[nodiscard]] std::string error(const ErrorStatistics& of);
[[nodiscard]] std::string milliseconds(double seconds);
[[nodiscard]] std::string count(double number);
[[nodiscard]] std::string metres(double length);

}  // namespace studies
}  // namespace consimd
