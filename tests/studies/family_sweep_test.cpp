// Studies beyond the paper's: families, scales, numbers of points, noise bounds and problems without a pose.
#include <consimd/studies/sweep.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/limits.hpp>
#include <consimd/studies/shard_merge.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/study_summary.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_families.hpp>
#include "small_study.hpp"
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;
using test::text_of;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr RunFacts kFacts{.isa = "scalar", .threads = 1};

/// A study with something of everything.
SweepOptions wide_study() {
  SweepOptions options = small_study();
  options.outlier_ratios = {0.5};
  options.sigmas = {0.5};
  options.trials = 4;
  options.points = {60, 120};
  options.families = {"gaussian", "heavy_tails"};
  options.bound_factors = {2.0, std::nullopt};
  options.no_pose = 0.25;
  options.solvers = {"tcf", "ransac"};
  return options;
}

/// The rows of trials.csv without their times: NaN is not equal to itself.
std::vector<std::string> rows_of(const TrialTable& table) {
  std::vector<std::string> rows;
  for (const TrialRecord& record : timeless(table)) rows.push_back(to_csv_row(record, true));
  return rows;
}

const TrialTable& wide_table() {
  static const TrialTable table = [] {
    TrialTable all(wide_study());
    run_sweep(all);
    return all;
  }();
  return table;
}

TEST(FamilySweep, EveryFamilyIsMeasuredAgainstItsOracle) {
  SweepOptions options = small_study();
  options.points = {300};
  options.outlier_ratios = {0.3};
  options.sigmas = {0.2, 1.0};
  options.trials = 2;
  options.families.clear();
  for (const synth::ProblemFamily& family : synth::problem_families()) options.families.emplace_back(family.name);
  TrialTable table(options);
  run_sweep(table);
  std::size_t right = 0;
  for (const TrialRecord& record : table.records()) {
    SCOPED_TRACE(record.family);
    const synth::Problem problem = synth::family_problem(record.family, {.correspondences = 300,
                                                                         .outlier_ratio = record.outlier_ratio,
                                                                         .sigma = record.sigma,
                                                                         .seed = options.seed,
                                                                         .trial = record.trial});
    const RigidTransform oracle = synth::oracle(problem);
    const double oracle_rmse = synth::rmse_true_inliers(problem, oracle);
    EXPECT_EQ(record.oracle_rmse_true_inliers, oracle_rmse);
    EXPECT_EQ(record.oracle_rotation_error_deg, synth::rotation_error_deg(oracle, problem.T_target_source));
    const bool gaussian = synth::problem_family(record.family).gaussian_noise;
    EXPECT_EQ(record.rmse_limit,
              gaussian ? 3.0 * record.sigma : std::sqrt(oracle_rmse * oracle_rmse + 6.0 * record.sigma * record.sigma));
    EXPECT_LT(oracle_rmse, record.rmse_limit) << "the oracle succeeds";
    EXPECT_GE(record.rmse_true_inliers, oracle_rmse * (1.0 - 1e-9)) << "none is better than the oracle";
    EXPECT_EQ(record.success, record.status != "no_consensus" && record.status != "degenerate_geometry" &&
                                  record.rmse_true_inliers < record.rmse_limit);
    EXPECT_EQ(record.noise_bound, 3.0 * record.sigma);
    EXPECT_EQ(record.scale_error, 0.0);
    right += record.success;
  }
  // With seven tenths of 300 rows true, nearly all are found.
  EXPECT_GE(right, table.size() * 9 / 10);
}

TEST(FamilySweep, DoesNotDependOnTheNumberOfThreads) {
  TrialTable one(wide_study()), two(wide_study());
  tbb::task_arena(1).execute([&] { run_sweep(one); });
  tbb::task_arena(2).execute([&] { run_sweep(two); });
  EXPECT_EQ(rows_of(one), rows_of(two));
  EXPECT_EQ(rows_of(one), rows_of(wide_table()));
}

TEST(FamilySweep, RowsReadBack) {
  for (const TrialRecord& record : wide_table().records()) {
    const std::string row = to_csv_row(record, true);
    EXPECT_EQ(to_csv_row(parse_trial_row(row.substr(0, row.size() - 1), true), true), row);
  }
}

TEST(FamilySweep, TellsOfConditionsAndOutcomes) {
  std::size_t without = 0;
  for (const TrialRecord& record : wide_table().records()) {
    EXPECT_EQ(record.true_pose, record.trial != 3);
    EXPECT_EQ(std::isnan(record.rotation_error_deg), !record.true_pose);
    EXPECT_EQ(std::isnan(record.oracle_rotation_error_deg), !record.true_pose);
    EXPECT_EQ(std::isnan(record.inlier_recall), !record.true_pose);
    without += !record.true_pose;
    if (record.bound_factor == "2") {
      EXPECT_EQ(record.noise_bound, 3.0);
    }
    if (record.bound_factor == "estimated") {
      EXPECT_NE(record.noise_bound, 1.5);
    }
    if (!record.true_pose) {
      EXPECT_FALSE(record.success);
    }
    if (record.outcome == kRight) {
      EXPECT_TRUE(record.success);
    }
    if (record.outcome == kRefused) {
      EXPECT_EQ(record.status, "no_consensus");
    }
  }
  EXPECT_EQ(without, wide_table().size() / 4);
}

TEST(FamilySweep, CellsAreOfTheProblemsWithAPose) {
  const std::vector<CellSummary> cells = summarise(wide_table()).cells();
  ASSERT_EQ(cells.size(), 16u);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const std::span<const TrialRecord> trials = wide_table().cell(k);
    double right = 0.0, error = 0.0;
    for (const TrialRecord& trial : trials.first(3)) {
      right += trial.success;
      error += trial.rotation_error_deg;
    }
    EXPECT_EQ(cells[k].trials, 4u);
    EXPECT_EQ(cells[k].without_pose, 1u);
    EXPECT_DOUBLE_EQ(cells[k].recall, right / 3.0);
    EXPECT_DOUBLE_EQ(cells[k].error.rotation_deg, error / 3.0);
    const OutcomeShares& shares = cells[k].outcomes;
    EXPECT_DOUBLE_EQ(shares.right + shares.wrong + shares.refused + shares.ambiguous, 1.0);
    EXPECT_EQ(cells[k].wrong_without_pose, trials[3].outcome == kWrong ? 1u : 0u);
  }
  const std::vector<RatioSummary> rows = summarise(wide_table()).ratios();
  ASSERT_EQ(rows.size(), 16u);
  EXPECT_EQ(rows[0].condition, (Condition{.points = 60, .bound_factor = 2.0}));
  EXPECT_EQ(rows[1].condition, rows[0].condition);
  EXPECT_EQ(rows[1].solver, "ransac");
  EXPECT_EQ(rows[15].condition, (Condition{.family = "heavy_tails", .points = 120, .bound_factor = std::nullopt}));
}

TEST(FamilySweep, FindsAnUnknownScale) {
  SweepOptions options = small_study();
  options.outlier_ratios = {0.3};
  options.sigmas = {0.1};
  options.scales = {ScaleKnowledge::known, ScaleKnowledge::unknown};
  options.solvers = {"pcr99", "teaser"};
  TrialTable table(options);
  run_sweep(table);
  double largest = 0.0;
  for (const TrialRecord& record : table.records()) {
    EXPECT_TRUE(record.success) << record.solver << " " << record.scale;
    if (record.scale == "known") {
      EXPECT_EQ(record.scale_error, 0.0);
    }
    largest = std::max(largest, record.scale_error);
  }
  EXPECT_GT(largest, 0.0);
  EXPECT_LT(largest, 0.01);
}

TEST(FamilySweep, OutsideSolversGetTheNoiseBound) {
  SweepOptions options = wide_study();
  options.solvers = {"mine"};
  options.trials = 1;
  options.families = {"gaussian"};
  options.points = {120};
  std::vector<double> bounds;
  options.outside = {{.name = "mine", .solve = [&](const OutsideProblem& problem) {
                        EXPECT_THAT(std::string(problem.name), HasSubstr("of family gaussian with 120 points"));
                        bounds.push_back(problem.noise_bound);
                        return OutsideReply(std::nullopt);
                      }}};
  TrialTable table(options);
  tbb::task_arena(1).execute([&] { run_sweep(table); });
  ASSERT_EQ(bounds.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_EQ(table.records()[k].noise_bound, bounds[k]);
  EXPECT_EQ(bounds[0], 3.0);
  EXPECT_GT(bounds[1], 0.0);
  EXPECT_EQ(table.records()[0].outcome, kRefused);
}

/// Runs the study, or a shard, in a folder until `most` trials are there.
TrialTable run_in(const fs::path& path, std::optional<Shard> shard = {}, std::size_t most = 1000) {
  TrialTable table(wide_study(), shard);
  StudyFolder folder(path, table, kFacts, false);
  std::size_t trials = table.filled();
  tbb::task_arena(1).execute([&] {
    run_sweep(table, {.on_trial =
                          [&](const TrialRecord& record) {
                            folder.append(record);
                            ++trials;
                          },
                      .stop_requested = [&] { return trials >= most; }});
  });
  if (table.complete()) folder.finish(table, kFacts);
  return table;
}

TEST(FamilySweep, StoppedAndResumedEqualsWhole) {
  const TemporaryFolder folder;
  EXPECT_FALSE(run_in(folder / "study", {}, 11).complete());
  const TrialTable table = run_in(folder / "study");
  EXPECT_TRUE(table.complete());
  EXPECT_EQ(rows_of(table), rows_of(wide_table()));
  const std::string text = text_of(folder / "study/trials.csv");
  EXPECT_EQ(text.substr(0, text.find('\n')), csv_header(kWideTrialColumns));
  EXPECT_EQ(std::ranges::count(text, '\n'), 65);
  const std::string cells = text_of(folder / "study/cells.csv");
  EXPECT_EQ(cells.substr(0, cells.find('\n')), csv_header(kWideCellColumns));
}

TEST(FamilySweep, TwoShardsMergedEqualTheWhole) {
  const TemporaryFolder folder;
  const std::vector<fs::path> parts{folder / "a", folder / "b"};
  const TrialTable first = run_in(parts[0], Shard{1, 2});
  const TrialTable second = run_in(parts[1], Shard{2, 2});
  EXPECT_EQ(first.size() + second.size(), wide_table().size());
  const MergedStudy merged = merge_shards(parts, false);
  EXPECT_EQ(rows_of(merged.table), rows_of(wide_table()));
  write_study(folder / "all", merged.table, {}, merged.summary, false);
  EXPECT_EQ(options_of(text_of(folder / "all/summary.json")).conditions(), wide_study().conditions());
}

TEST(FamilySweep, AFolderIsTakenUpWithTheSameConditionsOnly) {
  const std::string wide = summary_json(TrialTable(wide_study()), kFacts);
  const std::string paper = summary_json(TrialTable(small_study()), kFacts);
  EXPECT_EQ(difference(wide, TrialTable(wide_study())), "");
  EXPECT_EQ(difference(paper, TrialTable(small_study())), "");
  SweepOptions other = small_study();
  other.families = {"decoy"};
  EXPECT_EQ(difference(paper, TrialTable(other)), "it has family gaussian, not decoy");
  EXPECT_EQ(difference(summary_json(TrialTable(other), kFacts), TrialTable(small_study())),
            "it has family decoy, not gaussian");
  other = small_study();
  other.bound_factors = {0.5, std::nullopt};
  EXPECT_EQ(difference(paper, TrialTable(other)), "it has bound factor 1, not 0.5,estimated");
  other = small_study();
  other.no_pose = 0.1;
  EXPECT_EQ(difference(summary_json(TrialTable(other), kFacts), TrialTable(small_study())),
            "it has no pose 0.1, not 0.0");
  other = small_study();
  other.points = {100, 200};
  EXPECT_EQ(difference(paper, TrialTable(other)), "it has points 200, not 100,200");
}

TEST(FamilySweep, TheSummaryReadsBack) {
  const SweepOptions options = options_of(summary_json(TrialTable(wide_study()), kFacts));
  EXPECT_EQ(options.conditions(), wide_study().conditions());
  EXPECT_EQ(options.no_pose, 0.25);
  for (const char* const bad : {R"("family": 3)", R"("family": ["decoy"])",
                                R"("family": ["decoy"], "scale": ["known"], "bound factor": ["x"], "no pose": 0)",
                                R"("points": ["3"])", R"("points": -3)"}) {
    const std::string text = std::string(R"({"options": {"points": 3, "outliers": [0], "sigma": [1], "trials": 1,
      "solver": ["tcf"], "filter": "none", "seed": 1, )") +
                             bad + "}}";
    EXPECT_THROW((void)options_of(text), std::invalid_argument) << bad;
  }
}

TEST(FamilySweep, RefusesRowsOfAnotherStudy) {
  TrialTable table(wide_study());
  const TrialRecord good = wide_table().records()[3];
  for (const auto& spoil : std::vector<void (*)(TrialRecord&)>{
           [](TrialRecord& r) { r.family = "decoy"; }, [](TrialRecord& r) { r.scale = "unknown"; },
           [](TrialRecord& r) { r.points = 61; }, [](TrialRecord& r) { r.bound_factor = "3"; },
           [](TrialRecord& r) { r.true_pose = !r.true_pose; }}) {
    TrialRecord bad = good;
    spoil(bad);
    EXPECT_THROW(table.put(bad), std::invalid_argument);
  }
  EXPECT_NO_THROW(table.put(good));
}

TEST(FamilySweep, RefusesRowsThatNoTrialGives) {
  const TrialRecord good = wide_table().records()[0];
  const auto refused = [&](const auto& spoil, const char* says) {
    TrialRecord bad = good;
    spoil(bad);
    std::string row = to_csv_row(bad, true);
    row.pop_back();
    EXPECT_THAT([&] { (void)parse_trial_row(row, true); }, ThrowsMessage<std::invalid_argument>(HasSubstr(says)));
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  refused([](TrialRecord& r) { r.family = "magic"; }, "family 'magic'");
  refused([](TrialRecord& r) { r.scale = "some"; }, "scale 'some'");
  refused([](TrialRecord& r) { r.bound_factor = "-1"; }, "bound_factor");
  refused([](TrialRecord& r) { r.outcome = "fine"; }, "bad outcome 'fine'");
  refused([&](TrialRecord& r) { r.rmse_limit = kNaN; }, "bad rmse_limit");
  refused([&](TrialRecord& r) { r.oracle_rmse_true_inliers = -1.0; }, "bad oracle_rmse_true_inliers");
  refused([&](TrialRecord& r) { r.scale_error = kNaN; }, "bad scale_error");
  refused([&](TrialRecord& r) { r.noise_bound = kNaN; }, "bad noise_bound");
  refused([](TrialRecord& r) { r.true_pose = false; }, "bad rmse_limit");
  refused([](TrialRecord& r) { r.rmse_true_inliers = 2.0 * r.rmse_limit, r.success = true; }, "bad success");
}

TEST(FamilySweep, HasNoLimits) {
  EXPECT_NO_THROW(require_limits(small_study()));
  EXPECT_THAT([] { require_limits(wide_study()); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("map: the limit is that of the paper's problems")));
}

}  // namespace
}  // namespace consimd::studies
