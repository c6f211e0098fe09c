#include <consimd/studies/table_columns.hpp>

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/limits.hpp>
#include <consimd/studies/method_comparison.hpp>
#include <consimd/studies/run_record.hpp>
#include <consimd/studies/trial_comparison.hpp>
#include <consimd/studies/trial_record.hpp>
#include <consimd/synth/problem_families.hpp>
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

/// The file's first line, which scripts rely on: written out here, so that no change goes unnoticed.
TEST(TableColumns, AreThoseThatScriptsRead) {
  EXPECT_EQ(csv_header(kTrialColumns),
            "solver,outlier_ratio,sigma,trial,seed,status,success,rmse_true_inliers,rotation_error_deg,"
            "translation_error,oracle_rotation_error_deg,oracle_translation_error,inlier_precision,inlier_recall,"
            "seconds");
  EXPECT_EQ(csv_header(kCellColumns),
            "solver,outlier_ratio,sigma,trials,recall,recall_low,recall_high,rotation_error_deg_mean,"
            "translation_error_mean,oracle_rotation_error_deg_mean,oracle_translation_error_mean,seconds_median");
  EXPECT_EQ(csv_header(kWideTrialColumns),
            "family,scale,points,bound_factor,true_pose,outcome,rmse_limit,oracle_rmse_true_inliers,scale_error,"
            "noise_bound," +
                csv_header(kTrialColumns));
  EXPECT_EQ(csv_header(kWideCellColumns),
            "family,scale,points,bound_factor,success_share,wrong_success_share,refused_share,ambiguous_share,"
            "without_pose,wrong_without_pose,oracle_within_3_sigma," +
                csv_header(kCellColumns));
  EXPECT_EQ(csv_header(kLimitColumns),
            "sigma,problems,chance_support_mean,chance_support_max,fixed_support_mean,limit_outlier_ratio");
  EXPECT_EQ(csv_header(kRunColumns),
            "group,case,method,seed,status,success,rotation_error_deg,translation_error,rows,inliers,kept,"
            "kept_inliers,seconds,scale_error,limit_ratio,oracle_rotation_error_deg,oracle_translation_error");
}

/// Rows of a page's table of columns, in the words of the declarations.
template <typename Columns>
std::string page_rows(const Columns& columns) {
  std::string rows;
  for_each_column(columns, [&](const auto& column) {
    rows += "| `" + std::string(column.name) + "` | " + std::string(column.meaning) + " |\n";
  });
  return rows;
}

TEST(TableColumns, StandInThePages) {
  const std::filesystem::path docs = std::filesystem::path(CONSIMD_DOCS);
  const std::string study = test::text_of(docs / "noise_study.md");
  EXPECT_THAT(study, testing::HasSubstr(page_rows(kTrialColumns)));
  EXPECT_THAT(study, testing::HasSubstr(page_rows(kCellColumns)));
  EXPECT_THAT(study, testing::HasSubstr(page_rows(kTrialConditionColumns)));
  EXPECT_THAT(study, testing::HasSubstr(page_rows(kCellConditionColumns)));
  EXPECT_THAT(study, testing::HasSubstr(page_rows(kLimitColumns)));
  EXPECT_THAT(test::text_of(docs / "comparison.md"), testing::HasSubstr(page_rows(kRunColumns)));
}

/// The columns that name the cells in one table, what follows them in others.
TEST(TableColumns, OfComparisonsStandInThePages) {
  const std::string page = test::text_of(std::filesystem::path(CONSIMD_DOCS) / "noise_study.md");
  const std::string cell = page_rows(ProblemCell::columns<PairRow<ProblemCell>>());
  EXPECT_THAT(page, testing::HasSubstr(cell));
  for (const std::string& rows : {page_rows(kPairColumns<ProblemCell>), page_rows(kSolverColumns<ProblemCell>),
                                  page_rows(kCurveColumns<ProblemCell>)}) {
    EXPECT_TRUE(rows.starts_with(cell));
    EXPECT_THAT(page, testing::HasSubstr(rows.substr(cell.size())));
  }
  EXPECT_THAT(test::text_of(std::filesystem::path(CONSIMD_DOCS) / "comparison.md"),
              testing::HasSubstr(page_rows(GroupCell::columns<PairRow<GroupCell>>())));
}

TEST(ProblemFamilies, StandInThePage) {
  std::string rows;
  for (const synth::ProblemFamily& family : synth::problem_families()) {
    rows += "| `" + std::string(family.name) + "` | " + std::string(family.sentence) + " |\n";
  }
  EXPECT_THAT(test::text_of(std::filesystem::path(CONSIMD_DOCS) / "problem_families.md"), testing::HasSubstr(rows));
}

}  // namespace
}  // namespace consimd::studies
