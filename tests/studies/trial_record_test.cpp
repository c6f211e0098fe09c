#include <consimd/studies/trial_record.hpp>

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TrialRecord example() {
  return {.solver = "tcf",
          .outlier_ratio = 0.98,
          .sigma = 0.1,
          .trial = 7,
          .seed = std::numeric_limits<std::uint64_t>::max(),
          .status = "success",
          .success = true,
          .rmse_true_inliers = 1.0 / 7.0,
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

TEST(TrialRecord, RefusesWhatNoTrialGives) {
  const std::string good = to_csv_row(example());
  std::vector<std::string> fields;
  std::istringstream line(good.substr(0, good.size() - 1));
  for (std::string field; std::getline(line, field, ',');) fields.push_back(field);
  const auto parse_with = [&](std::size_t column, const std::string& value) {
    return [&fields, column, value] {
      std::string text;
      for (std::size_t i = 0; i < fields.size(); ++i) text += (i == 0 ? "" : ",") + (i == column ? value : fields[i]);
      static_cast<void>(parse_trial_row(text));
    };
  };
  const auto names = [](const std::string& text) { return ThrowsMessage<std::invalid_argument>(HasSubstr(text)); };
  EXPECT_NO_THROW(parse_with(5, "budget_exhausted")());
  EXPECT_THAT(parse_with(5, "splendid"), names("bad status 'splendid'"));
  EXPECT_THAT(parse_with(5, "unknown"), names("bad status 'unknown'"));
  for (const char* const value : {"7", "-1", "true", "00", ""}) {
    EXPECT_THAT(parse_with(6, value), names("expected 0 or 1, got '" + std::string(value) + "'"));
  }
  EXPECT_THAT(parse_with(7, "0.5"), names("bad success"));  // more than 3 sigma
  for (std::size_t column = 7; column < fields.size(); ++column) {
    for (const char* const value : {"inf", "-inf", "-1"}) EXPECT_THAT(parse_with(column, value), names("bad "));
    if (column != 12) {
      EXPECT_THAT(parse_with(column, "nan"), names("bad "));
    }
  }
  EXPECT_THAT(parse_with(13, "1.5"), names("bad inlier_recall '1.5'"));
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
