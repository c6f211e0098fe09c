#include <consimd/studies/cell_summary.hpp>

#include <gtest/gtest.h>

namespace consimd::studies {
namespace {

/// A solver's table with 2 noise levels of 2 trials; errors and times are small integers.
TrialTable hand_made() {
  SweepOptions options;
  options.outlier_ratios = {0.5};
  options.sigmas = {1.0, 2.0};
  options.trials = 2;
  TrialTable table(options);
  int k = 0;
  for (const double sigma : options.sigmas) {
    for (std::uint32_t trial = 0; trial < 2; ++trial) {
      ++k;
      table.put({.solver = "tcf",
                 .outlier_ratio = 0.5,
                 .sigma = sigma,
                 .trial = trial,
                 .seed = options.seed + trial,
                 .status = k == 4 ? "no_consensus" : "success",
                 .success = k != 4,
                 .rotation_error_deg = 1.0 * k,
                 .translation_error = 10.0 * k,
                 .oracle_rotation_error_deg = 1.0,
                 .oracle_translation_error = 5.0,
                 .seconds = 100.0 * k});
    }
  }
  return table;
}

TEST(CellSummary, AveragesAllTrialsFailuresIncluded) {
  const std::vector<CellSummary> cells = summarise(hand_made()).cells();
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_EQ(cells[0].recall, 1.0);
  EXPECT_EQ(cells[1].recall, 0.5);
  EXPECT_EQ(cells[1].error.rotation_deg, 3.5);
  EXPECT_EQ(cells[1].error.translation, 35.0);
  EXPECT_EQ(cells[1].oracle_error.rotation_deg, 1.0);
  EXPECT_EQ(cells[1].oracle_error.translation, 5.0);
  EXPECT_EQ(cells[1].seconds_median, 350.0);
  EXPECT_EQ(cells[1].recall_interval.low, wilson_interval(1, 2).low);
}

TEST(CellSummary, RowHasAFieldForEveryColumn) {
  CellSummary cell = summarise(hand_made()).cells()[1];
  cell.recall_interval = {0.25, 0.75};
  EXPECT_EQ(to_csv_row(cell), "tcf,0.5,2,2,0.5,0.25,0.75,3.5,35,1,5,350\n");
}

TEST(RatioSummary, SpansTheNoiseLevels) {
  const std::vector<RatioSummary> rows = summarise(hand_made()).ratios();
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].recall_min, 0.5);
  EXPECT_EQ(rows[0].recall_mean, 0.75);
  EXPECT_EQ(rows[0].error.rotation_deg, 2.5);
  EXPECT_EQ(rows[0].worst_ratio.rotation_deg, 3.5);
  EXPECT_EQ(rows[0].worst_ratio.translation, 7.0);
  EXPECT_EQ(rows[0].seconds_median, 250.0);
}

}  // namespace
}  // namespace consimd::studies
