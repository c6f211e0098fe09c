#include <consimd/studies/trial_record.hpp>

#include <fmt/format.h>

#include "files/csv_fields.hpp"

namespace consimd::studies {

std::string to_csv_row(const TrialRecord& r) {
  return fmt::format("{},{},{},{},{},{},{:d},{},{},{},{},{},{},{},{}\n", r.solver, r.outlier_ratio, r.sigma, r.trial,
                     r.seed, r.status, r.success, r.rmse_true_inliers, r.rotation_error_deg, r.translation_error,
                     r.oracle_rotation_error_deg, r.oracle_translation_error, r.inlier_precision, r.inlier_recall,
                     r.seconds);
}

TrialRecord parse_trial_row(std::string_view line) {
  CsvFields fields(line);
  TrialRecord record;
  record.solver = fields.text();
  record.outlier_ratio = fields.number<double>();
  record.sigma = fields.number<double>();
  record.trial = fields.number<std::uint32_t>();
  record.seed = fields.number<std::uint64_t>();
  record.status = fields.text();
  record.success = fields.number<int>() != 0;
  record.rmse_true_inliers = fields.number<double>();
  record.rotation_error_deg = fields.number<double>();
  record.translation_error = fields.number<double>();
  record.oracle_rotation_error_deg = fields.number<double>();
  record.oracle_translation_error = fields.number<double>();
  record.inlier_precision = fields.number<double>();
  record.inlier_recall = fields.number<double>();
  record.seconds = fields.number<double>();
  fields.finish();
  return record;
}

}  // namespace consimd::studies
