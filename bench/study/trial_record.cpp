#include "study/trial_record.hpp"

#include <charconv>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

namespace consimd::study {
namespace {

/// Takes the fields of a line from left to right.
class FieldReader {
 public:
  explicit FieldReader(std::string_view line) : rest_(line) {}

  std::string_view text() {
    if (exhausted_) throw std::invalid_argument("too few columns");
    const std::size_t comma = rest_.find(',');
    const std::string_view field = rest_.substr(0, comma);
    exhausted_ = comma == std::string_view::npos;
    if (!exhausted_) rest_.remove_prefix(comma + 1);
    return field;
  }

  template <typename T>
  T number() {
    const std::string_view field = text();
    T value{};
    const char* end = field.data() + field.size();
    const auto [rest, error] = std::from_chars(field.data(), end, value);
    if (error != std::errc() || rest != end) throw std::invalid_argument(fmt::format("bad value '{}'", field));
    return value;
  }

  void finish() const {
    if (!exhausted_) throw std::invalid_argument("too many columns");
  }

 private:
  std::string_view rest_;
  bool exhausted_ = false;
};

}  // namespace

std::string to_csv_row(const TrialRecord& r) {
  return fmt::format("{},{},{},{},{},{},{:d},{},{},{},{},{},{},{},{}\n", r.solver, r.outlier_ratio, r.sigma, r.trial,
                     r.seed, r.status, r.success, r.rmse_true_inliers, r.rotation_error_deg, r.translation_error,
                     r.oracle_rotation_error_deg, r.oracle_translation_error, r.inlier_precision, r.inlier_recall,
                     r.seconds);
}

TrialRecord parse_trial_row(std::string_view line) {
  FieldReader fields(line);
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

}  // namespace consimd::study
