// One row of trials.csv.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)

namespace consimd::studies {

/// The outcome of one solver on one synthetic problem. Lengths in metres.
struct TrialRecord {
  std::string solver;
  double outlier_ratio = 0.0;
  double sigma = 0.0;
  std::uint32_t trial = 0;
  std::uint64_t seed = 0;  ///< the solver's
  std::string status = {};
  bool success = false;  ///< a pose, and an RMSE of the true inliers below 3 sigma
  // Errors of the returned pose, or of the identity when there is none.
  double rmse_true_inliers = 0.0;
  double rotation_error_deg = 0.0;
  double translation_error = 0.0;
  // Errors of least squares on the true inliers.
  double oracle_rotation_error_deg = 0.0;
  double oracle_translation_error = 0.0;
  double inlier_precision = 0.0;  ///< NaN when no inlier was returned
  double inlier_recall = 0.0;
  double seconds = 0.0;

  bool operator==(const TrialRecord&) const = default;
};

inline constexpr std::string_view kTrialColumns =
    "solver,outlier_ratio,sigma,trial,seed,status,success,rmse_true_inliers,rotation_error_deg,translation_error,"
    "oracle_rotation_error_deg,oracle_translation_error,inlier_precision,inlier_recall,seconds";

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const TrialRecord& record);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] TrialRecord parse_trial_row(std::string_view line);

}  // namespace consimd::studies

#pragma GCC visibility pop
