// One row of runs.csv.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#pragma GCC visibility push(default)

namespace consimd::studies {

/// One run of a method on a case.
struct RunRecord {
  std::string group;
  std::string case_name;
  std::string method;
  std::uint64_t seed = 0;
  std::string status = {};
  bool success = false;
  // NaN without a pose.
  double rotation_error_deg = 0.0;
  double translation_error = 0.0;
  std::uint64_t rows = 0;          ///< of the case
  std::uint64_t inliers = 0;       ///< true ones among them
  std::uint64_t kept = 0;          ///< rows left in the end
  std::uint64_t kept_inliers = 0;  ///< true ones among them
  double seconds = 0.0;
  double scale_error = 0.0;  ///< relative, 0 of a solver that was given the scale; NaN without a pose

  bool operator==(const RunRecord&) const = default;

  [[nodiscard]] bool has_pose() const noexcept { return !std::isnan(rotation_error_deg); }
};

inline constexpr std::string_view kRunColumns =
    "group,case,method,seed,status,success,rotation_error_deg,translation_error,rows,inliers,kept,kept_inliers,seconds,"
    "scale_error";

/// A line with its newline. Numbers read back to the same bits.
[[nodiscard]] std::string to_csv_row(const RunRecord& record);

/// Inverse of `to_csv_row`, the newline left out. Throws std::invalid_argument that says what is wrong.
[[nodiscard]] RunRecord parse_run_row(std::string_view line);

}  // namespace consimd::studies

#pragma GCC visibility pop
