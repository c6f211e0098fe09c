// What a study reports of its trials: cells.csv, and one line per solver and outlier ratio.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/statistics.hpp>
#include <consimd/studies/table_columns.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

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

inline constexpr std::tuple kCellColumns{
    Column{"solver", &CellSummary::solver, "name of the solver"},
    Column{"outlier_ratio", &CellSummary::outlier_ratio, "share of wrong correspondences"},
    Column{"sigma", &CellSummary::sigma, "standard deviation of an inlier's noise, metres an axis"},
    Column{"trials", &CellSummary::trials, "problems of the cell"},
    Column{"recall", &CellSummary::recall, "share of successes"},
    Column{"recall_low", member_of(&CellSummary::recall_interval, &Interval::low),
           "lower end of its 95 % Wilson interval"},
    Column{"recall_high", member_of(&CellSummary::recall_interval, &Interval::high), "upper end of that interval"},
    Column{"rotation_error_deg_mean", member_of(&CellSummary::error, &PoseError::rotation_deg),
           "mean over all trials, failures included, degrees"},
    Column{"translation_error_mean", member_of(&CellSummary::error, &PoseError::translation),
           "mean over all trials, failures included, metres"},
    Column{"oracle_rotation_error_deg_mean", member_of(&CellSummary::oracle_error, &PoseError::rotation_deg),
           "that of least squares on the true inliers, degrees"},
    Column{"oracle_translation_error_mean", member_of(&CellSummary::oracle_error, &PoseError::translation),
           "that of least squares on the true inliers, metres"},
    Column{"seconds_median", &CellSummary::seconds_median, "median time of a registration"},
};

/// A line with its newline.
[[nodiscard]] std::string to_csv_row(const CellSummary& cell);

/// Both, made of the records of a study one by one. Holds those of one cell, and all times of one outlier ratio.
class StudySummary {
 public:
  explicit StudySummary(const SweepOptions& options)
      : trials_(options.trials), levels_(options.sigmas.size()), solvers_(options.solvers.size()) {}

  /// Records must come in the order of the table, all of them.
  void add(const TrialRecord& record);

  /// In the order of the table.
  [[nodiscard]] const std::vector<CellSummary>& cells() const noexcept { return cells_; }
  /// Ordered by outlier ratio, then solver, so that solvers stand beside each other.
  [[nodiscard]] std::vector<RatioSummary> ratios() const;
  [[nodiscard]] const FailureCounts& failures() const noexcept { return failures_; }

 private:
  std::size_t trials_;
  std::size_t levels_;
  std::size_t solvers_;
  std::vector<TrialRecord> open_;  // of a cell
  std::vector<double> seconds_;    // of an outlier ratio
  FailureCounts failures_;
  std::vector<CellSummary> cells_;
  std::vector<RatioSummary> rows_;  // in the order of the table
};

/// That of a table that is complete and keeps records.
[[nodiscard]] StudySummary summarise(const TrialTable& table);

}  // namespace studies
}  // namespace consimd
