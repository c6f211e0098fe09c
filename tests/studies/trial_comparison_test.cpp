#include <consimd/studies/trial_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "statistics/comparison_files.hpp"

namespace consimd::studies {
namespace {

using testing::HasSubstr;

TrialRecord trial_of(const char* solver, double sigma, std::uint32_t trial, bool success) {
  return {.solver = solver,
          .outlier_ratio = 0.9,
          .sigma = sigma,
          .trial = trial,
          .status = success ? "success" : "no_consensus",
          .success = success,
          .rmse_true_inliers = success ? 1.8 * sigma : 100.0,
          .rotation_error_deg = success ? 0.2 : 120.0,
          .translation_error = success ? 0.1 : 50.0,
          .oracle_rotation_error_deg = 0.1,
          .oracle_translation_error = 0.1,
          .seconds = 0.01 * (trial + 1),
          .family = "decoy",
          .scale = "known",
          .points = 300,
          .bound_factor = "1"};
}

/// Two noise levels of ten trials: slow solves all, in twice the time; quick fails in four of each level and is less
/// precise.
std::vector<TrialRecord> two_solvers() {
  std::vector<TrialRecord> trials;
  for (const char* const solver : {"slow", "quick"}) {
    for (const double sigma : {1.0, 2.0}) {
      for (std::uint32_t k = 0; k < 10; ++k) {
        const bool slow = std::string(solver) == "slow";
        trials.push_back(trial_of(solver, sigma, k, slow || k < 6));
        if (slow) trials.back().seconds *= 2.0;
        if (!slow && k < 6) trials.back().rotation_error_deg = 0.3;
      }
    }
  }
  return trials;
}

TEST(TrialComparison, PairsTrialsOfOneLevelAndOfAll) {
  const std::vector<PairRow<ProblemCell>> pairs = compare_solvers(two_solvers(), 1).pairs;
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].cell.sigma, 1.0);
  EXPECT_EQ(pairs[1].cell.sigma, 2.0);
  EXPECT_TRUE(std::isnan(pairs[2].cell.sigma));
  EXPECT_EQ(pairs[2].trials, 20u);
  for (const PairRow<ProblemCell>& pair : pairs) {
    EXPECT_EQ(pair.a, "slow");
    EXPECT_EQ(pair.b, "quick");
    EXPECT_EQ(pair.only_b, 0u);
    EXPECT_DOUBLE_EQ(pair.recall.value, 0.4);
    EXPECT_GT(pair.recall.interval.low, 0.0);
    EXPECT_LT(pair.recall.interval.high, 0.9);
    // Of the problems that both solved: failures are told by the recall.
    EXPECT_NEAR(pair.rotation_deg.value, -0.1, 1e-12);
    EXPECT_NEAR(pair.rotation_deg.interval.low, -0.1, 1e-12);
    EXPECT_NEAR(pair.translation.value, 0.0, 1e-12);
    EXPECT_NEAR(pair.time_ratio.value, 2.0, 1e-12);
    EXPECT_NEAR(pair.time_ratio.interval.low, 2.0, 1e-12);
    EXPECT_NEAR(pair.time_ratio.interval.high, 2.0, 1e-12);
  }
  EXPECT_EQ(pairs[0].only_a, 4u);
  EXPECT_NEAR(pairs[0].p_value, 0.125, 1e-15);
  EXPECT_NEAR(pairs[0].p_value_holm, 0.25, 1e-15);
  EXPECT_EQ(pairs[2].only_a, 8u);
  EXPECT_NEAR(pairs[2].p_value, 0.0078125, 1e-15);
  EXPECT_EQ(pairs[2].p_value_holm, pairs[2].p_value) << "one row of all levels";
  // More trials, narrower.
  EXPECT_LT(pairs[2].recall.interval.high - pairs[2].recall.interval.low,
            pairs[0].recall.interval.high - pairs[0].recall.interval.low);
}

TEST(TrialComparison, SaysWhoBeatsWhom) {
  const std::vector<PairRow<ProblemCell>> pairs = compare_solvers(two_solvers(), 1).pairs;
  EXPECT_EQ(verdict(pairs[0]), "");
  EXPECT_EQ(verdict(pairs[2]),
            "decoy, 90 % outliers, 300 points: slow beats quick (8 problems to 0, p = 0.0078, Holm's 0.0078)");
  PairRow<ProblemCell> other = pairs[2];
  std::swap(other.only_a, other.only_b);
  EXPECT_THAT(verdict(other), HasSubstr("quick beats slow (8 problems to 0"));
  other.p_value_holm = 0.06;
  EXPECT_EQ(verdict(other), "");
}

TEST(TrialComparison, CountsFailuresInQuantilesAndTimes) {
  const std::vector<SolverRow<ProblemCell>> solvers = compare_solvers(two_solvers(), 1).solvers;
  ASSERT_EQ(solvers.size(), 6u);
  const SolverRow<ProblemCell>& slow = solvers[0];
  const SolverRow<ProblemCell>& quick = solvers[2];
  EXPECT_EQ(slow.solver, "slow");
  EXPECT_EQ(quick.solver, "quick");
  EXPECT_EQ(slow.rotation_deg_p90, 0.2);
  EXPECT_EQ(quick.rotation_deg_median, 0.3);
  EXPECT_EQ(quick.recall, 0.6);
  EXPECT_NEAR(quick.recall_interval.low, 0.313, 1e-3);
  EXPECT_EQ(quick.rotation_deg_p90, std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(slow.rotation_efficiency, 0.25);
  EXPECT_DOUBLE_EQ(slow.translation_efficiency, 1.0);
  EXPECT_DOUBLE_EQ(slow.seconds_recall_90, 0.18);
  EXPECT_DOUBLE_EQ(quick.seconds_recall_50, 0.05);
  EXPECT_EQ(quick.seconds_recall_90, std::numeric_limits<double>::infinity());
}

TEST(TrialComparison, CurvesRiseToTheRecallAtTheStudysOwnLimit) {
  const TrialComparison comparison = compare_solvers(two_solvers(), 1);
  double before = 0.0;
  std::string solver;
  for (const CurveRow<ProblemCell>& point : comparison.curves) {
    if (point.solver != solver) before = 0.0;
    solver = point.solver;
    EXPECT_GE(point.recall, before);
    before = point.recall;
    // An RMSE of 1.8 sigma is 0.6 of the limit.
    if (std::abs(point.threshold - 0.6) < 0.01) continue;
    EXPECT_EQ(point.recall, point.threshold > 0.6 ? (solver == "slow" ? 1.0 : 0.6) : 0.0) << point.threshold;
    EXPECT_LE(point.recall_interval.low, point.recall);
  }
}

TEST(TrialComparison, LeavesProblemsWithoutAPoseOut) {
  std::vector<TrialRecord> trials = two_solvers();
  for (TrialRecord& trial : trials) {
    if (trial.trial == 9) trial.true_pose = false;
  }
  EXPECT_EQ(compare_solvers(trials, 1).pairs[2].trials, 18u);
}

TEST(TrialComparison, RefusesSolversWithOtherProblems) {
  std::vector<TrialRecord> trials = two_solvers();
  trials.pop_back();
  EXPECT_THROW((void)compare_solvers(trials, 1), std::invalid_argument);
  trials = two_solvers();
  trials.back().trial = 10;
  EXPECT_THROW((void)compare_solvers(trials, 1), std::invalid_argument);
}

TEST(TrialComparison, HasNoPairsOfOneSolverAndNothingOfNone) {
  std::vector<TrialRecord> trials = two_solvers();
  trials.resize(20);
  const TrialComparison one = compare_solvers(trials, 1);
  EXPECT_TRUE(one.pairs.empty());
  EXPECT_EQ(one.solvers.size(), 3u);
  EXPECT_TRUE(compare_solvers({}, 1).solvers.empty());
}

TEST(TrialComparison, ErrorsWithoutACommonSuccessAreUnknown) {
  std::vector<TrialRecord> trials = two_solvers();
  for (TrialRecord& trial : trials) trial.success = trial.solver == "slow";
  const PairRow<ProblemCell> pair = compare_solvers(trials, 1).pairs[2];
  EXPECT_EQ(pair.recall.value, 1.0);
  EXPECT_TRUE(std::isnan(pair.rotation_deg.value));
  EXPECT_TRUE(std::isnan(pair.rotation_deg.interval.high));
  EXPECT_NEAR(pair.time_ratio.value, 2.0, 1e-12);
}

TEST(TrialComparison, FilesHaveARowEach) {
  const TrialComparison comparison = compare_solvers(two_solvers(), 1);
  const std::string pairs = detail::table_text(kPairColumns<ProblemCell>, comparison.pairs);
  EXPECT_EQ(std::ranges::count(pairs, '\n'), 4);
  EXPECT_THAT(pairs,
              testing::StartsWith("family,scale,points,bound_factor,outlier_ratio,sigma,a,b,trials,only_a,only_b,"
                                  "p_value,p_value_holm,recall_difference,recall_difference_low,"));
  EXPECT_THAT(pairs, HasSubstr("\ndecoy,known,300,1,0.9,nan,slow,quick,20,8,0,"));
  const std::string solvers = detail::table_text(kSolverColumns<ProblemCell>, comparison.solvers);
  EXPECT_EQ(std::ranges::count(solvers, '\n'), 7);
  EXPECT_THAT(solvers, HasSubstr("\ndecoy,known,300,1,0.9,nan,quick,20,0.6,"));
  EXPECT_EQ(std::ranges::count(detail::table_text(kCurveColumns<ProblemCell>, comparison.curves), '\n'), 1 + 2 * 51);
}

}  // namespace
}  // namespace consimd::studies
