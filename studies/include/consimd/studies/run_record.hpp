// One row of runs.csv.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/table_columns.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// One run of a method on a case; `kRunColumns` says what the members mean.
struct RunRecord {
  std::string group;
  std::string case_name;
  std::string method;
  std::uint64_t seed = 0;
  std::string status = {};
  bool success = false;
  double rotation_error_deg = 0.0;
  double translation_error = 0.0;
  std::uint64_t rows = 0;
  std::uint64_t inliers = 0;
  std::uint64_t kept = 0;
  std::uint64_t kept_inliers = 0;
  double seconds = 0.0;
  double scale_error = 0.0;
  double limit_ratio = 0.0;
  double oracle_rotation_error_deg = 0.0;
  double oracle_translation_error = 0.0;

  bool operator==(const RunRecord&) const = default;

  [[nodiscard]] bool has_pose() const noexcept { return !std::isnan(rotation_error_deg); }
};

inline constexpr std::tuple kRunColumns{
    Column{"group", &RunRecord::group,
           "cases that stand in one block of a table: a data set, a stand-in, a noise cell"},
    Column{"case", &RunRecord::case_name, "name of the case within its group"},
    Column{"method", &RunRecord::method,
           "solver, solver after TCF's filter, whole pipeline from scans, or stages of TCF"},
    Column{"seed", &RunRecord::seed, "the method's seed"},
    Column{"status", &RunRecord::status,
           "why the solver stopped; of stages: pose, no_pose, or rows (a set without one); crashed or "
           "timed_out of an outside program"},
    Column{"success", &RunRecord::success, "1: a pose within the limits of the case; else 0"},
    Column{"rotation_error_deg", &RunRecord::rotation_error_deg,
           "angle between pose and truth, degrees; NaN without a pose"},
    Column{"translation_error", &RunRecord::translation_error,
           "distance of the translations, unit of the case; NaN without a pose"},
    Column{"rows", &RunRecord::rows, "correspondences of the case"},
    Column{"inliers", &RunRecord::inliers, "true inliers among them"},
    Column{"kept", &RunRecord::kept, "rows left in the end: a pose's inliers, or what the last stage let through"},
    Column{"kept_inliers", &RunRecord::kept_inliers, "true inliers among those"},
    Column{"seconds", &RunRecord::seconds, "time of the method alone"},
    Column{"scale_error", &RunRecord::scale_error,
           "relative error of the scale; 0 where the scale was given, NaN without a pose"},
    Column{"limit_ratio", &RunRecord::limit_ratio,
           "error of the pose over the limit of success, the larger quotient where there are two limits; NaN without a "
           "pose or a true inlier"},
    Column{"oracle_rotation_error_deg", &RunRecord::oracle_rotation_error_deg,
           "rotation error of least squares on the true inliers, degrees; NaN with fewer than three"},
    Column{"oracle_translation_error", &RunRecord::oracle_translation_error,
           "its translation error, unit of the case; NaN likewise"},
};

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const RunRecord& record);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] RunRecord parse_run_row(std::string_view line);

}  // namespace studies
}  // namespace consimd
