#include <consimd/studies/run_record.hpp>

#include <fmt/format.h>

#include "files/csv_fields.hpp"

namespace consimd::studies {

std::string to_csv_row(const RunRecord& r) {
  return fmt::format("{},{},{},{},{},{:d},{},{},{},{},{},{},{},{}\n", r.group, r.case_name, r.method, r.seed, r.status,
                     r.success, r.rotation_error_deg, r.translation_error, r.rows, r.inliers, r.kept, r.kept_inliers,
                     r.seconds, r.scale_error);
}

RunRecord parse_run_row(std::string_view line) {
  CsvFields fields(line);
  RunRecord record;
  record.group = fields.text();
  record.case_name = fields.text();
  record.method = fields.text();
  record.seed = fields.number<std::uint64_t>();
  record.status = fields.text();
  record.success = fields.number<int>() != 0;
  record.rotation_error_deg = fields.number<double>();
  record.translation_error = fields.number<double>();
  record.rows = fields.number<std::uint64_t>();
  record.inliers = fields.number<std::uint64_t>();
  record.kept = fields.number<std::uint64_t>();
  record.kept_inliers = fields.number<std::uint64_t>();
  record.seconds = fields.number<double>();
  record.scale_error = fields.number<double>();
  fields.finish();
  return record;
}

}  // namespace consimd::studies
