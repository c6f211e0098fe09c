// One row of trials.csv.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/table_columns.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The outcome of one solver on one synthetic problem; `kTrialColumns` says what the members mean.
struct TrialRecord {
  std::string solver;
  double outlier_ratio = 0.0;
  double sigma = 0.0;
  std::uint32_t trial = 0;
  std::uint64_t seed = 0;
  std::string status = {};
  bool success = false;
  double rmse_true_inliers = 0.0;
  double rotation_error_deg = 0.0;
  double translation_error = 0.0;
  double oracle_rotation_error_deg = 0.0;
  double oracle_translation_error = 0.0;
  double inlier_precision = 0.0;
  double inlier_recall = 0.0;
  double seconds = 0.0;

  bool operator==(const TrialRecord&) const = default;
};

inline constexpr std::tuple kTrialColumns{
    Column{"solver", &TrialRecord::solver, "name of the solver"},
    Column{"outlier_ratio", &TrialRecord::outlier_ratio, "share of wrong correspondences"},
    Column{"sigma", &TrialRecord::sigma, "standard deviation of an inlier's noise, metres an axis"},
    Column{"trial", &TrialRecord::trial, "number of the problem in its cell, from 0"},
    Column{"seed", &TrialRecord::seed, "the solver's seed"},
    Column{"status", &TrialRecord::status, "why the solver stopped; crashed or timed_out of an outside program"},
    Column{"success", &TrialRecord::success, "1: a pose, and an RMSE of the true inliers below 3 sigma; else 0"},
    Column{"rmse_true_inliers", &TrialRecord::rmse_true_inliers,
           "root mean square residual of the true inliers under the pose, metres; without a pose, here and in the "
           "errors, under the identity"},
    Column{"rotation_error_deg", &TrialRecord::rotation_error_deg, "angle between pose and truth, degrees"},
    Column{"translation_error", &TrialRecord::translation_error, "distance of the translations, metres"},
    Column{"oracle_rotation_error_deg", &TrialRecord::oracle_rotation_error_deg,
           "that of least squares on the true inliers, degrees"},
    Column{"oracle_translation_error", &TrialRecord::oracle_translation_error,
           "that of least squares on the true inliers, metres"},
    Column{"inlier_precision", &TrialRecord::inlier_precision,
           "share of true inliers among the reported ones; NaN where none was reported"},
    Column{"inlier_recall", &TrialRecord::inlier_recall, "share of the true inliers that was reported"},
    Column{"seconds", &TrialRecord::seconds, "time of the registration alone"},
};

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const TrialRecord& record);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] TrialRecord parse_trial_row(std::string_view line);

}  // namespace studies
}  // namespace consimd
