#include <consimd/studies/trial_record.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

TrialRecord example() {
  return {.solver = "tcf",
          .outlier_ratio = 0.98,
          .sigma = 0.1,
          .trial = 7,
          .seed = std::numeric_limits<std::uint64_t>::max(),
          .status = "success",
          .success = true,
          .rmse_true_inliers = 0.1 + 0.2,
          .rotation_error_deg = 1e-300,
          .translation_error = 1.0 / 3.0,
          .oracle_rotation_error_deg = 5e-324,
          .oracle_translation_error = 1e300,
          .inlier_precision = 0.0,
          .inlier_recall = 1.0,
          .seconds = 0.012345678901234567};
}

TEST(TrialRecord, ReadsBackToTheSameBits) {
  const std::string row = to_csv_row(example());
  ASSERT_EQ(row.back(), '\n');
  EXPECT_EQ(parse_trial_row(row.substr(0, row.size() - 1)), example());
}

TEST(TrialRecord, KeepsNotANumber) {
  TrialRecord record = example();
  record.inlier_precision = std::numeric_limits<double>::quiet_NaN();
  const std::string row = to_csv_row(record);
  EXPECT_TRUE(std::isnan(parse_trial_row(row.substr(0, row.size() - 1)).inlier_precision));
}

TEST(TrialRecord, RefusesOtherLines) {
  const std::string row = to_csv_row(example());
  const std::string line = row.substr(0, row.size() - 1);
  EXPECT_THROW((void)parse_trial_row(""), std::invalid_argument);
  EXPECT_THROW((void)parse_trial_row(line + ",1"), std::invalid_argument);
  EXPECT_THROW((void)parse_trial_row(line.substr(0, line.rfind(','))), std::invalid_argument);
  EXPECT_THROW((void)parse_trial_row(line + "x"), std::invalid_argument);
  EXPECT_THROW((void)parse_trial_row(csv_header(kTrialColumns)), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::studies
