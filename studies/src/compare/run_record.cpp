#include <consimd/studies/run_record.hpp>

#include <algorithm>
#include <cmath>

#include "files/csv_rows.hpp"
#include "files/row_checks.hpp"

namespace consimd::studies {

std::string to_csv_row(const RunRecord& record) { return csv_row(kRunColumns, record); }

RunRecord parse_run_row(std::string_view line) {
  RunRecord record = parse_csv_row<RunRecord>(kRunColumns, line);
  const auto is_error = [&](double value) { return record.has_pose() ? is_size(value) : std::isnan(value); };
  const bool of_stages = record.status == "pose" || record.status == "no_pose" || record.status == "rows";
  require_column(of_stages || is_status(record.status), "status", record.status);
  require_column(record.success == (record.has_pose() && record.limit_ratio <= 1.0), "success", record.success);
  require_column(is_error(record.rotation_error_deg), "rotation_error_deg", record.rotation_error_deg);
  require_column(is_error(record.translation_error), "translation_error", record.translation_error);
  require_column(is_error(record.scale_error), "scale_error", record.scale_error);
  // Without true inliers there is nothing to hold against the limit, and no oracle.
  const auto is_known_error = [](double value) { return std::isnan(value) || is_size(value); };
  require_column(is_known_error(record.limit_ratio), "limit_ratio", record.limit_ratio);
  require_column(is_known_error(record.oracle_rotation_error_deg), "oracle_rotation_error_deg",
                 record.oracle_rotation_error_deg);
  require_column(is_known_error(record.oracle_translation_error), "oracle_translation_error",
                 record.oracle_translation_error);
  require_column(record.inliers <= record.rows, "inliers", record.inliers);
  require_column(record.kept <= record.rows, "kept", record.kept);
  require_column(record.kept_inliers <= std::min(record.kept, record.inliers), "kept_inliers", record.kept_inliers);
  require_column(is_size(record.seconds), "seconds", record.seconds);
  return record;
}

}  // namespace consimd::studies
