#include <consimd/studies/comparison.hpp>

#include <cmath>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/stand_ins.hpp>

#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/method.hpp>
#include <consimd/studies/paper_tables.hpp>
#include "small_comparison.hpp"
#include "temporary_folder.hpp"

namespace consimd::studies {
namespace {

using test::TemporaryFolder;
using test::text_of;
using test::write_text;

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Comparison, ReportsWhatTheSolverReturns) {
  Comparison comparison = small_comparison({"tcf", "tcf+ransac"});
  run_comparison(comparison);
  ASSERT_TRUE(comparison.complete());
  const std::vector<RunRecord> runs = comparison.runs_of("facade", "tcf+ransac");
  ASSERT_EQ(runs.size(), 4u);  // two pairs, two seeds
  const synth::StandIn& facade = synth::stand_in("facade");
  const synth::Problem problem = synth::stand_in_problem(facade, 5, 1);
  const Registration result =
      register_by_name("ransac", problem.correspondences(), {.noise_bound = 0.2, .seed = 7, .filter = Filter::tcf});
  const RunRecord& run = runs[3];
  EXPECT_EQ(run.case_name, "1");
  EXPECT_EQ(run.seed, 7u);
  EXPECT_EQ(run.status, to_string(result.status));
  EXPECT_EQ(run.rotation_error_deg, synth::rotation_error_deg(result.T_target_source, problem.T_target_source));
  EXPECT_EQ(run.translation_error, synth::translation_error(result.T_target_source, problem.T_target_source));
  EXPECT_EQ(run.success, result.has_pose() && run.rotation_error_deg <= 5.0 && run.translation_error <= 0.5);
  EXPECT_TRUE(run.success);
  EXPECT_EQ(run.rows, problem.size());
  EXPECT_EQ(run.inliers, static_cast<std::uint64_t>(std::ranges::count(problem.is_inlier, 1)));
  EXPECT_EQ(run.kept, result.inliers.size());
  EXPECT_GT(run.seconds, 0.0);
}

TEST(Comparison, NoiseCellsHaveTheStudysMeasure) {
  std::vector<CaseGroup> groups =
      noise_groups({.points = 200, .outlier_ratios = {0.5, 0.8}, .sigmas = {0.1, 1.0}, .trials = 2, .seed = 3});
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[1].name, "noise 80 %");
  for (CaseGroup& group : groups) group.methods = {"tcf"};
  Comparison comparison(std::move(groups), 1);
  run_comparison(comparison);
  for (const RunRecord& run : comparison.done()) EXPECT_TRUE(run.success) << run.group << " " << run.case_name;
  EXPECT_THROW((void)noise_groups({.outlier_ratios = {1.0}, .sigmas = {1.0}}), std::invalid_argument);
}

TEST(Comparison, DoesNotDependOnTheNumberOfThreads) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 3);
  Comparison one = small_comparison(), three = small_comparison();
  tbb::task_arena(1).execute([&] { run_comparison(one); });
  tbb::task_arena(3).execute([&] { run_comparison(three); });
  EXPECT_EQ(timeless(one), timeless(three));
}

TEST(Comparison, StoppedAndResumedEqualsWhole) {
  Comparison whole = small_comparison();
  run_comparison(whole);
  const TemporaryFolder folder;
  const ComparisonFacts facts{.options = {{"seed", "5"}}, .isa = "scalar"};
  for (const std::size_t most : {3u, 7u, 1000u}) {
    Comparison part = small_comparison();
    ComparisonFolder files(folder / "c", part, facts, false);
    const ComparisonControl control{.on_run = [&](const RunRecord& record) { files.append(record); },
                                    .stop_requested = [&] { return part.filled() >= most; }};
    run_comparison(part, control);
    files.write(part, {}, facts);
    EXPECT_EQ(part.filled(), std::min(most, whole.size()));
  }
  // As a crash leaves it: a line cut short.
  const std::string text = text_of(folder / "c/runs.csv");
  write_text(folder / "c/runs.csv", text.substr(0, text.size() - 5));
  Comparison last = small_comparison();
  ComparisonFolder files(folder / "c", last, facts, false);
  EXPECT_EQ(last.filled(), last.size() - 1);
  run_comparison(last);
  EXPECT_EQ(timeless(last), timeless(whole));
}

TEST(Comparison, StartsWithTheFirstCaseOfEveryGroup) {
  Comparison comparison = small_comparison({"1R"});
  std::vector<std::string> order;
  run_comparison(comparison, {.on_run = [&](const RunRecord& run) { order.push_back(run.group + run.case_name); }});
  EXPECT_EQ(order, (std::vector<std::string>{"facade0", "facade0", "office0", "office0", "facade1", "facade1",
                                             "office1", "office1"}));
}

TEST(ComparisonFolder, NamesTheDifferenceToAnotherComparison) {
  const TemporaryFolder folder;
  Comparison comparison = small_comparison();
  const ComparisonFacts facts{.options = {{"seed", "5"}}, .isa = "scalar"};
  const ComparisonFacts other{.options = {{"seed", "6"}}, .isa = "scalar"};
  { const ComparisonFolder files(folder / "c", comparison, facts, false); }
  const auto open = [&] { const ComparisonFolder files(folder / "c", comparison, other, false); };
  EXPECT_THAT(open, ThrowsMessage<std::runtime_error>(HasSubstr("it has seed 5, not 6")));
  { const ComparisonFolder files(folder / "c", comparison, other, true); }
  EXPECT_NO_THROW(open());
  write_text(folder / "c/runs.csv", csv_header(kRunColumns) + "\nfacade,0,magic,5,success,1,0,0,1,1,1,1,0,0,0,0,0\n");
  EXPECT_THAT(open,
              ThrowsMessage<std::runtime_error>(HasSubstr("runs.csv:2: magic on facade 0 with seed 5 is not of")));
  std::filesystem::remove(folder / "c/comparison.json");
  EXPECT_THAT(open, ThrowsMessage<std::runtime_error>(HasSubstr("no comparison.json says")));
}

TEST(ComparisonFolder, IsHeldByOneProcess) {
  const TemporaryFolder folder;
  Comparison first = small_comparison(), second = small_comparison();
  const ComparisonFacts facts{.options = {{"seed", "5"}}, .isa = "scalar"};
  const ComparisonFolder files(folder / "c", first, facts, false);
  const std::string before = text_of(folder / "c/comparison.json");
  for (const bool fresh : {false, true}) {
    EXPECT_THAT([&] { const ComparisonFolder other(folder / "c", second, facts, fresh); },
                ThrowsMessage<std::runtime_error>(HasSubstr("another process is writing to this folder")));
  }
  EXPECT_EQ(text_of(folder / "c/comparison.json"), before);
}

TEST(Comparison, RefusesWhatATableCannotHold) {
  const auto with_names = [](const std::string& group, const std::string& of) {
    return [group, of] { const Comparison c({{.name = group, .cases = {{.name = of}}, .methods = {"tcf"}}}, 1); };
  };
  EXPECT_NO_THROW(with_names("a", "b")());
  for (const std::string name : {"", "a,b", "a\nb", "a\"b"}) {
    EXPECT_THROW(with_names(name, "b")(), std::invalid_argument) << name;
    EXPECT_THROW(with_names("a", name)(), std::invalid_argument) << name;
  }
  EXPECT_THROW(
      {
        const Comparison twice({{.name = "a", .cases = {{.name = "b"}, {.name = "b"}}, .methods = {"tcf"}}}, 1);
      },
      std::invalid_argument);
}

TEST(RunRecord, ReadsBackTheSameBits) {
  const RunRecord run{.group = "kitti01",
                      .case_name = "sigma 0.1 trial 3",
                      .method = "tcf+ransac",
                      .seed = ~std::uint64_t{0},
                      .status = "success",
                      .success = true,
                      .rotation_error_deg = 0.1 + 0.2,
                      .translation_error = 1e-17,
                      .rows = 4,
                      .inliers = 3,
                      .kept = 2,
                      .kept_inliers = 1,
                      .seconds = 1.0 / 3.0,
                      .scale_error = 1.0 / 7.0,
                      .limit_ratio = 1.0 / 11.0,
                      .oracle_rotation_error_deg = 1.0 / 13.0,
                      .oracle_translation_error = 1e-19};
  std::string line = to_csv_row(run);
  line.pop_back();
  EXPECT_EQ(parse_run_row(line), run);
  RunRecord none = run;
  none.success = false;
  none.rotation_error_deg = none.translation_error = none.scale_error = none.limit_ratio = std::nan("");
  line = to_csv_row(none);
  line.pop_back();
  EXPECT_FALSE(parse_run_row(line).has_pose());
  EXPECT_THROW((void)parse_run_row("a,b"), std::invalid_argument);
  EXPECT_THROW((void)parse_run_row(line + ",1"), std::invalid_argument);
}

TEST(Method, RunsStagesOnWhatTheLastOneKept) {
  const synth::Problem problem = synth::stand_in_problem(synth::stand_in("facade"), 1, 0);
  const Correspondences correspondences = problem.correspondences();
  const auto run = [&](std::string_view name) { return run_method(name, correspondences, 0.2, 1); };
  const Outcome one = run("1R"), both = run("1R+2R"), three = run("1R+2R+3R"), all = run("1R+2R+3R+IRLS");
  for (const auto& [outer, inner] : {std::pair(&one, &both), std::pair(&both, &three), std::pair(&three, &all)}) {
    EXPECT_TRUE(std::ranges::includes(outer->kept, inner->kept));
    EXPECT_GE(inner->kept.size(), 3u);
  }
  EXPECT_EQ(both.status, "rows");
  EXPECT_FALSE(both.has_pose);
  EXPECT_TRUE(three.has_pose);
  EXPECT_TRUE(all.has_pose);
  EXPECT_LT(synth::translation_error(all.T_target_source, problem.T_target_source), 0.5);
  for (const std::string_view name :
       {"", "4R", "1R+", "+1R", "magic", "tcf+magic", "plain-ransac-", "plain-ransac-x"}) {
    EXPECT_THROW((void)run(name), std::invalid_argument) << name;
  }
}

TEST(Method, FindsTheScale) {
  std::vector<CaseGroup> groups =
      noise_groups({.points = 300, .outlier_ratios = {0.5}, .sigmas = {1.0}, .trials = 2, .scale = 0.2});
  groups.front().methods = {"scale+teaser", "scale+pcr99", "teaser"};
  Comparison comparison(std::move(groups), 1);
  run_comparison(comparison);
  for (const std::string_view method : {"scale+teaser", "scale+pcr99"}) {
    for (const RunRecord& run : comparison.runs_of("noise 50 %", method)) {
      EXPECT_TRUE(run.success) << method;
      EXPECT_LT(run.scale_error, 0.01) << method;
      EXPECT_GT(run.scale_error, 0.0) << method;
    }
  }
  for (const RunRecord& run : comparison.runs_of("noise 50 %", "teaser")) {
    EXPECT_FALSE(run.success);
    if (run.has_pose()) {
      EXPECT_NEAR(run.scale_error, 4.0, 1e-12);
    }
  }
  EXPECT_THROW((void)run_method("scale+tcf", {}, 1.0, 1), std::invalid_argument);
}

TEST(Method, PlainRansacDrawsAllItsSamples) {
  const Correspondences correspondences = synth::stand_in_problem(synth::stand_in("facade"), 1, 0).correspondences();
  const Outcome outcome = run_method(plain_ransac(20'000), correspondences, 0.2, 1);
  EXPECT_TRUE(outcome.has_pose);
  EXPECT_EQ(outcome.status, "success");
}

TEST(SuccessLimits, ArePresetsByName) {
  EXPECT_EQ(preset_limits("case", "anything"), std::nullopt);
  EXPECT_EQ(preset_limits("paper", "ETH"), (PoseLimits{5.0, 0.5}));
  EXPECT_EQ(preset_limits("paper", "KITTI"), (PoseLimits{5.0, 1.0}));
  EXPECT_EQ(preset_limits("kitti06", "KITTI"), (PoseLimits{5.0, 0.6}));
  EXPECT_EQ(preset_limits("3dmatch", "anything"), (PoseLimits{15.0, 0.3}));
  EXPECT_EQ(preset_limits("5,0.6", "anything"), (PoseLimits{5.0, 0.6}));
  EXPECT_THROW((void)preset_limits("paper", "3DMatch"), std::invalid_argument);
  EXPECT_THROW((void)preset_limits("3dmatch-rmse", "3DMatch"), std::invalid_argument);
  for (const char* bad : {"5", "5,", ",1", "0,1", "1,-1", "1,inf", "1,2,3", "1, 2"}) {
    EXPECT_THROW((void)preset_limits(bad, "ETH"), std::invalid_argument) << bad;
  }
  EXPECT_THROW((void)preset_limits("magic", "ETH"), std::invalid_argument);
  for (const LimitPreset& preset : limit_presets()) EXPECT_NO_THROW(require_known_preset(preset.name));
}

}  // namespace
}  // namespace consimd::studies
