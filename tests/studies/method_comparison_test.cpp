#include <consimd/studies/method_comparison.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "small_comparison.hpp"

namespace consimd::studies {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Groups "a" and "b" of `cases` cases each, two seeds a case.
Comparison two_groups(int cases, const std::vector<std::string>& methods) {
  std::vector<CaseGroup> groups;
  for (const char* const name : {"a", "b"}) {
    groups.push_back({.name = name, .methods = methods});
    for (int k = 0; k < cases; ++k) groups.back().cases.push_back({.name = std::to_string(k)});
  }
  return {std::move(groups), 2};
}

RunRecord run_of(const std::string& group, int on, const std::string& method, std::uint64_t seed, bool success) {
  return {.group = group,
          .case_name = std::to_string(on),
          .method = method,
          .seed = seed,
          .status = success ? "success" : "no_consensus",
          .success = success,
          .rotation_error_deg = success ? 0.2 : kNaN,
          .translation_error = success ? 0.1 : kNaN,
          .seconds = method == "quick" ? 0.001 : 0.004,
          .scale_error = success ? 0.0 : kNaN,
          .limit_ratio = success ? 0.6 : kNaN,
          .oracle_rotation_error_deg = 0.1,
          .oracle_translation_error = 0.1};
}

/// "slow" solves all with both seeds. "quick" solves half of the cases of "a" with one seed of the two, and all of "b".
/// "1R" gives rows alone.
Comparison compared(int cases) {
  Comparison comparison = two_groups(cases, {"slow", "1R", "quick"});
  for (const char* const group : {"a", "b"}) {
    for (int k = 0; k < cases; ++k) {
      for (const std::uint64_t seed : {1U, 2U}) {
        comparison.put(run_of(group, k, "slow", seed, true));
        comparison.put(run_of(group, k, "quick", seed, std::string(group) == "b" || seed == 1 || k % 2 == 0));
        RunRecord rows = run_of(group, k, "1R", seed, false);
        rows.status = "rows";
        comparison.put(rows);
      }
    }
  }
  return comparison;
}

TEST(MethodComparison, CountsCasesNotRuns) {
  const MethodComparison methods = compare_methods(compared(20));
  ASSERT_EQ(methods.pairs.size(), 3u);
  EXPECT_EQ(methods.pairs[0].cell.group, "a");
  EXPECT_EQ(methods.pairs[1].cell.group, "b");
  EXPECT_EQ(methods.pairs[2].cell.group, kAllGroups);
  const PairRow<GroupCell>& pair = methods.pairs[0];
  EXPECT_EQ(pair.a, "slow");
  EXPECT_EQ(pair.b, "quick");
  EXPECT_EQ(pair.trials, 20u);
  EXPECT_EQ(pair.only_a, 10u);  // of 20 runs that quick lacks one in each of ten cases
  EXPECT_EQ(pair.only_b, 0u);
  EXPECT_NEAR(pair.p_value, std::ldexp(1.0, -9), 1e-15);
  EXPECT_DOUBLE_EQ(pair.recall.value, 0.25);
  EXPECT_NEAR(pair.rotation_deg.value, 0.0, 1e-12);  // both solved every case with some seed
  EXPECT_NEAR(pair.time_ratio.value, 4.0, 1e-12);
  EXPECT_EQ(methods.pairs[2].trials, 40u);
  EXPECT_EQ(methods.pairs[2].only_a, 10u);
  EXPECT_DOUBLE_EQ(methods.pairs[2].recall.value, 0.125);
  EXPECT_LT(methods.pairs[2].recall.interval.high, methods.pairs[0].recall.interval.high);
  EXPECT_EQ(methods.pairs[1].p_value_holm, 1.0);
  EXPECT_NEAR(methods.pairs[0].p_value_holm, 2.0 * methods.pairs[0].p_value, 1e-15);
}

TEST(MethodComparison, TellsQuantilesOfAllRuns) {
  const MethodComparison methods = compare_methods(compared(20));
  ASSERT_EQ(methods.solvers.size(), 6u);
  const SolverRow<GroupCell>&slow = methods.solvers[0], &quick = methods.solvers[2];
  EXPECT_EQ(slow.solver, "slow");
  EXPECT_EQ(quick.solver, "quick");
  EXPECT_EQ(quick.cell.group, "a");
  EXPECT_EQ(quick.trials, 40u);
  EXPECT_EQ(quick.recall, 0.75);
  EXPECT_EQ(quick.rotation_deg_median, 0.2);
  EXPECT_EQ(quick.rotation_deg_p90, std::numeric_limits<double>::infinity());
  EXPECT_DOUBLE_EQ(quick.rotation_efficiency, 0.25);
  EXPECT_DOUBLE_EQ(quick.translation_efficiency, 1.0);
  EXPECT_EQ(quick.seconds_recall_50, 0.001);
  EXPECT_EQ(quick.seconds_recall_90, std::numeric_limits<double>::infinity());
  EXPECT_EQ(slow.seconds_recall_99, 0.004);
  EXPECT_EQ(methods.solvers[4].cell.group, kAllGroups);
  EXPECT_EQ(methods.solvers[4].trials, 80u);
  for (const CurveRow<GroupCell>& point : methods.curves) {
    const double recall = point.solver == "slow" || point.cell.group == "b" ? 1.0
                          : point.cell.group == "a"                         ? 0.75
                                                                            : 0.875;
    if (std::abs(point.threshold - 0.6) < 0.01) continue;
    EXPECT_EQ(point.recall, point.threshold > 0.6 ? recall : 0.0) << point.threshold << point.cell.group;
  }
  EXPECT_EQ(methods.curves.size(), 2u * 3u * 51u);
}

TEST(MethodComparison, LeavesCasesOutThatNotAllMethodsHaveRun) {
  Comparison comparison = two_groups(2, {"slow", "quick"});
  EXPECT_TRUE(compare_methods(comparison).solvers.empty());
  for (const std::uint64_t seed : {1U, 2U}) {
    comparison.put(run_of("a", 0, "slow", seed, true));
    comparison.put(run_of("a", 1, "slow", seed, true));
    comparison.put(run_of("a", 0, "quick", seed, true));
  }
  comparison.put(run_of("a", 1, "quick", 1, false));
  const MethodComparison methods = compare_methods(comparison);
  ASSERT_EQ(methods.pairs.size(), 2u);  // "a" and all
  EXPECT_EQ(methods.pairs[1].trials, 1u);
  EXPECT_EQ(methods.pairs[1].only_a, 0u);
}

TEST(MethodComparison, RunsKnowTheirLimitAndTheirOracle) {
  Comparison comparison = small_comparison({"tcf", "1R+2R", "ransac"});
  run_comparison(comparison);
  for (const RunRecord& run : comparison.runs_of("office", "tcf")) {
    EXPECT_EQ(run.limit_ratio, std::max(run.rotation_error_deg / 5.0, run.translation_error / 0.5));
    EXPECT_EQ(run.success, run.limit_ratio <= 1.0);
    EXPECT_GT(run.oracle_rotation_error_deg, 0.0);
    EXPECT_LT(run.oracle_rotation_error_deg, 1.0);
    EXPECT_LT(run.oracle_translation_error, 0.1);
  }
  EXPECT_TRUE(std::isnan(comparison.runs_of("office", "1R+2R").front().limit_ratio));
  const MethodComparison methods = compare_methods(comparison);
  ASSERT_EQ(methods.pairs.size(), 3u);  // tcf and ransac in two groups and in all
  EXPECT_EQ(methods.pairs[2].trials, 4u);
  for (const SolverRow<GroupCell>& row : methods.solvers)
    EXPECT_NEAR(row.translation_efficiency, 1.0, 0.9) << row.solver;
}

TEST(MethodComparison, NoGroupMayBeCalledAllGroups) {
  EXPECT_THAT(([] { const Comparison c({{.name = "all groups", .methods = {"tcf"}}}, 1); }),
              ThrowsMessage<std::invalid_argument>(HasSubstr("group 'all groups'")));
}

}  // namespace
}  // namespace consimd::studies
