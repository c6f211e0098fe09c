// What a study reports of its trials: cells.csv, and one line per solver and outlier ratio.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/studies/statistics.hpp>
#include <consimd/studies/trial_table.hpp>

#pragma GCC visibility push(default)

namespace consimd::studies {

/// Rotation error in degrees and translation error in metres.
struct PoseError {
  double rotation_deg = 0.0;
  double translation = 0.0;
};

/// The trials of one solver at one outlier ratio and noise level. Errors are means over all trials, failures included.
struct CellSummary {
  std::string solver;
  double outlier_ratio = 0.0;
  double sigma = 0.0;
  std::uint32_t trials = 0;
  double recall = 0.0;
  Interval recall_interval = {};
  PoseError error = {};
  PoseError oracle_error = {};
  double seconds_median = 0.0;
};

/// The cells of one solver and outlier ratio, over all noise levels.
struct RatioSummary {
  std::string solver;
  double outlier_ratio = 0.0;
  double recall_min = 0.0;
  double recall_mean = 0.0;
  PoseError error = {};
  PoseError oracle_error = {};
  PoseError worst_ratio = {};   ///< largest quotient of a cell's mean error and the oracle's
  double seconds_median = 0.0;  ///< over all trials
};

inline constexpr std::string_view kCellColumns =
    "solver,outlier_ratio,sigma,trials,recall,recall_low,recall_high,rotation_error_deg_mean,translation_error_mean,"
    "oracle_rotation_error_deg_mean,oracle_translation_error_mean,seconds_median";

/// A line with its newline.
[[nodiscard]] std::string to_csv_row(const CellSummary& cell);

/// In the order of the table, which must be complete.
[[nodiscard]] std::vector<CellSummary> summarise_cells(const TrialTable& table);

/// Ordered by outlier ratio, then solver, so that solvers stand beside each other. The table must be complete.
[[nodiscard]] std::vector<RatioSummary> summarise_ratios(const TrialTable& table);

}  // namespace consimd::studies

#pragma GCC visibility pop
