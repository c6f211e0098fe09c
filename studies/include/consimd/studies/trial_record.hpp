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

  // What a study beyond the paper's tells besides.
  std::string family = {};
  std::string scale = {};
  std::uint64_t points = 0;
  std::string bound_factor = {};
  bool true_pose = true;
  std::string outcome = {};
  double rmse_limit = 0.0;
  double oracle_rmse_true_inliers = 0.0;
  double scale_error = 0.0;
  double noise_bound = 0.0;

  bool operator==(const TrialRecord&) const = default;
};

inline constexpr std::tuple kTrialColumns{
    Column{"solver", &TrialRecord::solver, "name of the solver"},
    Column{"outlier_ratio", &TrialRecord::outlier_ratio, "share of wrong correspondences"},
    Column{"sigma", &TrialRecord::sigma, "standard deviation of an inlier's noise, metres an axis"},
    Column{"trial", &TrialRecord::trial, "number of the problem in its cell, from 0"},
    Column{"seed", &TrialRecord::seed, "the solver's seed"},
    Column{"status", &TrialRecord::status, "why the solver stopped; crashed or timed_out of an outside program"},
    Column{"success", &TrialRecord::success,
           "1: a pose, and an RMSE of the true inliers below 3 sigma, or below rmse_limit where there is that column; "
           "else 0"},
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

// Outcomes. An ambiguous pose is an answer with a warning, right or wrong, so these are exclusive where `success` and
// the status ambiguous are not.
inline constexpr std::string_view kRight = "success";
inline constexpr std::string_view kWrong = "wrong_success";
inline constexpr std::string_view kRefused = "refused";
inline constexpr std::string_view kAmbiguous = "ambiguous";

/// The columns that a study beyond the paper's has before those above.
inline constexpr std::tuple kTrialConditionColumns{
    Column{"family", &TrialRecord::family, "family of the problem"},
    Column{"scale", &TrialRecord::scale, "unknown: the solver has to find the scale of the source; else known"},
    Column{"points", &TrialRecord::points, "correspondences of the problem"},
    Column{"bound_factor", &TrialRecord::bound_factor,
           "noise bound given over 3 sigma; estimated: the solver was given none"},
    Column{"true_pose", &TrialRecord::true_pose,
           "1: the problem has a true pose; 0: it has none, then the errors of the pose and the oracle are NaN"},
    Column{"outcome", &TrialRecord::outcome,
           "ambiguous: by its status; else success, wrong_success (a pose that is wrong) or refused (no pose)"},
    Column{"rmse_limit", &TrialRecord::rmse_limit, "RMSE of the true inliers below which a pose succeeds, metres"},
    Column{"oracle_rmse_true_inliers", &TrialRecord::oracle_rmse_true_inliers,
           "root mean square residual of the true inliers under the oracle's pose, metres"},
    Column{"scale_error", &TrialRecord::scale_error, "relative error of the scale found; 0 where it is known"},
    Column{"noise_bound", &TrialRecord::noise_bound, "noise bound that the solver used, metres"},
};
inline constexpr auto kWideTrialColumns = std::tuple_cat(kTrialConditionColumns, kTrialColumns);

// In what follows `wide` is `SweepOptions::beyond_paper` of the study: its rows have all columns.

/// The first line of trials.csv, without its newline.
[[nodiscard]] std::string trial_header(bool wide);

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const TrialRecord& record, bool wide = false);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] TrialRecord parse_trial_row(std::string_view line, bool wide = false);

}  // namespace studies
}  // namespace consimd
