#include <consimd/studies/trial_record.hpp>

#include <cmath>

#include "files/csv_rows.hpp"
#include "files/row_checks.hpp"

namespace consimd::studies {

std::string to_csv_row(const TrialRecord& record) { return csv_row(kTrialColumns, record); }

TrialRecord parse_trial_row(std::string_view line) {
  TrialRecord record = parse_csv_row<TrialRecord>(kTrialColumns, line);
  require_column(is_status(record.status), "status", record.status);
  require_column(is_size(record.rmse_true_inliers), "rmse_true_inliers", record.rmse_true_inliers);
  require_column(!record.success || record.rmse_true_inliers < 3.0 * record.sigma, "success", record.success);
  require_column(is_size(record.rotation_error_deg), "rotation_error_deg", record.rotation_error_deg);
  require_column(is_size(record.translation_error), "translation_error", record.translation_error);
  require_column(is_size(record.oracle_rotation_error_deg), "oracle_rotation_error_deg",
                 record.oracle_rotation_error_deg);
  require_column(is_size(record.oracle_translation_error), "oracle_translation_error", record.oracle_translation_error);
  require_column(std::isnan(record.inlier_precision) || is_share(record.inlier_precision), "inlier_precision",
                 record.inlier_precision);
  require_column(is_share(record.inlier_recall), "inlier_recall", record.inlier_recall);
  require_column(is_size(record.seconds), "seconds", record.seconds);
  return record;
}

}  // namespace consimd::studies
