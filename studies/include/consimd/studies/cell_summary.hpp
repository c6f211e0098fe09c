// What a study reports of its trials: cells.csv, and one line per solver and outlier ratio.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/statistics.hpp>
#include <consimd/studies/table_columns.hpp>
#include <consimd/studies/trial_comparison.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// Rotation error in degrees and translation error in metres.
struct PoseError {
  double rotation_deg = 0.0;
  double translation = 0.0;
};

/// Shares of trials by their outcome, which add up to 1, and of what the paper's measure says of the oracle.
struct OutcomeShares {
  double right = 0.0;
  double wrong = 0.0;
  double refused = 0.0;
  double ambiguous = 0.0;
};

/// The trials of one solver in one condition at one outlier ratio and noise level. Recall and errors are means over all
/// trials with a true pose, failures included.
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

  // What a study beyond the paper's tells besides.
  std::string family = {};
  std::string scale = {};
  std::uint64_t points = 0;
  std::string bound_factor = {};
  OutcomeShares outcomes = {};
  std::uint32_t without_pose = 0;
  std::uint32_t wrong_without_pose = 0;
  double oracle_within_3_sigma = 0.0;
};

/// The cells of one solver, condition and outlier ratio, over all noise levels.
struct RatioSummary {
  std::string solver;
  double outlier_ratio = 0.0;
  double recall_min = 0.0;
  double recall_mean = 0.0;
  PoseError error = {};
  PoseError oracle_error = {};
  PoseError worst_ratio = {};   ///< largest quotient of a cell's mean error and the oracle's
  double seconds_median = 0.0;  ///< over all trials
  Condition condition = {};
  OutcomeShares outcomes = {};
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

/// The columns that a study beyond the paper's has before those above.
inline constexpr std::tuple kCellConditionColumns{
    Column{"family", &CellSummary::family, "family of the problems"},
    Column{"scale", &CellSummary::scale, "unknown: the solver has to find the scale of the source; else known"},
    Column{"points", &CellSummary::points, "correspondences of a problem"},
    Column{"bound_factor", &CellSummary::bound_factor,
           "noise bound given over 3 sigma; estimated: the solver was given none"},
    Column{"success_share", member_of(&CellSummary::outcomes, &OutcomeShares::right),
           "share of all trials whose outcome is success"},
    Column{"wrong_success_share", member_of(&CellSummary::outcomes, &OutcomeShares::wrong),
           "share of all trials with a pose that is wrong and not called ambiguous"},
    Column{"refused_share", member_of(&CellSummary::outcomes, &OutcomeShares::refused),
           "share of all trials without a pose"},
    Column{"ambiguous_share", member_of(&CellSummary::outcomes, &OutcomeShares::ambiguous),
           "share of all trials with the status ambiguous, right or wrong"},
    Column{"without_pose", &CellSummary::without_pose,
           "problems without a true pose; recall and errors are over the others"},
    Column{"wrong_without_pose", &CellSummary::wrong_without_pose, "those of them with the outcome wrong_success"},
    Column{"oracle_within_3_sigma", &CellSummary::oracle_within_3_sigma,
           "share of the problems with a true pose in which the oracle's RMSE is below 3 sigma"},
};
inline constexpr auto kWideCellColumns = std::tuple_cat(kCellConditionColumns, kCellColumns);

/// The first line of cells.csv, without its newline. `wide`: of a study beyond the paper's.
[[nodiscard]] std::string cell_header(bool wide);

/// A line with its newline.
[[nodiscard]] std::string to_csv_row(const CellSummary& cell, bool wide = false);

/// Records that are kept to compare solvers, some 100 MB.
inline constexpr std::size_t kMostCompared = std::size_t{1} << 18U;

/// Both, made of the records of a study one by one. Holds those of one cell, and all times of one outlier ratio; of a
/// study with several solvers and no more than `kMostCompared` trials, all.
class StudySummary {
 public:
  explicit StudySummary(const SweepOptions& options)
      : trials_(options.trials),
        levels_(options.sigmas.size()),
        ratios_(options.outlier_ratios.size()),
        solvers_(options.solvers.size()),
        wide_(options.beyond_paper()),
        seed_(options.seed),
        compares_(options.solvers.size() > 1 && options.cells() <= kMostCompared / options.trials),
        conditions_(options.conditions()) {}

  /// Records must come in the order of the table, all of them.
  void add(const TrialRecord& record);

  /// In the order of the table.
  [[nodiscard]] const std::vector<CellSummary>& cells() const noexcept { return cells_; }
  /// Ordered by condition, outlier ratio, then solver, so that solvers stand beside each other.
  [[nodiscard]] std::vector<RatioSummary> ratios() const;
  [[nodiscard]] const FailureCounts& failures() const noexcept { return failures_; }
  /// Solvers beside each other, of all records; none of a study with one solver or too many trials.
  [[nodiscard]] std::optional<TrialComparison> comparison() const;
  /// Whether it is one of a study beyond the paper's.
  [[nodiscard]] bool wide() const noexcept { return wide_; }

 private:
  std::size_t trials_;
  std::size_t levels_;
  std::size_t ratios_;
  std::size_t solvers_;
  bool wide_;
  std::uint64_t seed_;
  bool compares_;
  std::vector<Condition> conditions_;
  std::vector<TrialRecord> open_;  // of a cell
  std::vector<double> seconds_;    // of an outlier ratio
  std::vector<TrialRecord> compared_;
  FailureCounts failures_;
  std::vector<CellSummary> cells_;
  std::vector<RatioSummary> rows_;  // in the order of the table
};

/// That of a table that is complete and keeps records.
[[nodiscard]] StudySummary summarise(const TrialTable& table);

}  // namespace studies
}  // namespace consimd
