#include <consimd/studies/trial_record.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <consimd/studies/condition.hpp>
#include <consimd/synth/problem_families.hpp>

#include "files/csv_rows.hpp"
#include "files/row_checks.hpp"

namespace consimd::studies {
namespace {

/// Without a true pose there is nothing that a pose could be off.
bool is_error(const TrialRecord& record, double value) { return record.true_pose ? is_size(value) : std::isnan(value); }

void require_condition(const TrialRecord& record) {
  static_cast<void>(synth::problem_family(record.family));
  static_cast<void>(scale_knowledge_by_name(record.scale));
  static_cast<void>(parse_bound_factor(record.bound_factor));
  constexpr std::array kOutcomes{kRight, kWrong, kRefused, kAmbiguous};
  require_column(std::ranges::find(kOutcomes, record.outcome) != kOutcomes.end(), "outcome", record.outcome);
  require_column(is_error(record, record.rmse_limit), "rmse_limit", record.rmse_limit);
  require_column(is_error(record, record.oracle_rmse_true_inliers), "oracle_rmse_true_inliers",
                 record.oracle_rmse_true_inliers);
  require_column(is_error(record, record.scale_error), "scale_error", record.scale_error);
  require_column(is_size(record.noise_bound), "noise_bound", record.noise_bound);
  require_column(record.true_pose || !record.success, "success", record.success);
}

}  // namespace

std::string trial_header(bool wide) { return wide ? csv_header(kWideTrialColumns) : csv_header(kTrialColumns); }

std::string to_csv_row(const TrialRecord& record, bool wide) {
  return wide ? csv_row(kWideTrialColumns, record) : csv_row(kTrialColumns, record);
}

TrialRecord parse_trial_row(std::string_view line, bool wide) {
  TrialRecord record =
      wide ? parse_csv_row<TrialRecord>(kWideTrialColumns, line) : parse_csv_row<TrialRecord>(kTrialColumns, line);
  if (wide) require_condition(record);
  const double limit = wide ? record.rmse_limit : 3.0 * record.sigma;
  require_column(is_status(record.status), "status", record.status);
  require_column(is_error(record, record.rmse_true_inliers), "rmse_true_inliers", record.rmse_true_inliers);
  require_column(!record.success || record.rmse_true_inliers < limit, "success", record.success);
  require_column(is_error(record, record.rotation_error_deg), "rotation_error_deg", record.rotation_error_deg);
  require_column(is_error(record, record.translation_error), "translation_error", record.translation_error);
  require_column(is_error(record, record.oracle_rotation_error_deg), "oracle_rotation_error_deg",
                 record.oracle_rotation_error_deg);
  require_column(is_error(record, record.oracle_translation_error), "oracle_translation_error",
                 record.oracle_translation_error);
  require_column(std::isnan(record.inlier_precision) || is_share(record.inlier_precision), "inlier_precision",
                 record.inlier_precision);
  require_column(record.true_pose ? is_share(record.inlier_recall) : std::isnan(record.inlier_recall), "inlier_recall",
                 record.inlier_recall);
  require_column(is_size(record.seconds), "seconds", record.seconds);
  return record;
}

}  // namespace consimd::studies
