#include <consimd/studies/sweep.hpp>

#include <atomic>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include "small_study.hpp"

namespace consimd::studies {
namespace {

TEST(Sweep, FillsTheTableInOrder) {
  TrialTable table(small_study());
  run_sweep(table);
  ASSERT_TRUE(table.complete());
  ASSERT_EQ(table.size(), 12u);
  std::size_t slot = 0;
  for (const double ratio : table.options().outlier_ratios) {
    for (const double sigma : table.options().sigmas) {
      for (std::uint32_t trial = 0; trial < 3; ++trial, ++slot) {
        EXPECT_EQ(table.records()[slot].outlier_ratio, ratio);
        EXPECT_EQ(table.records()[slot].sigma, sigma);
        EXPECT_EQ(table.records()[slot].trial, trial);
        EXPECT_EQ(table.records()[slot].seed, 5u + trial);
      }
    }
  }
}

TEST(Sweep, ReportsWhatTheSolverReturns) {
  TrialTable table(small_study());
  run_sweep(table);
  const TrialRecord& record = table.records()[10];  // ratio 0.8, sigma 1, trial 1
  const synth::Problem problem =
      synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.8, .sigma = 1.0, .seed = 5, .trial = 1});
  const Registration result = register_by_name("tcf", problem.correspondences(), {.noise_bound = 3.0, .seed = 6});
  EXPECT_EQ(record.status, to_string(result.status));
  EXPECT_EQ(record.success, result.has_pose() && synth::rmse_true_inliers(problem, result.T_target_source) < 3.0);
  EXPECT_EQ(record.rotation_error_deg, synth::rotation_error_deg(result.T_target_source, problem.T_target_source));
  EXPECT_EQ(record.translation_error, synth::translation_error(result.T_target_source, problem.T_target_source));
  EXPECT_EQ(record.oracle_translation_error, synth::translation_error(synth::oracle(problem), problem.T_target_source));
}

TEST(Sweep, DoesNotDependOnTheNumberOfThreads) {
  TrialTable one(small_study());
  tbb::task_arena(1).execute([&] { run_sweep(one); });
  TrialTable three(small_study());
  tbb::task_arena(3).execute([&] { run_sweep(three); });
  EXPECT_EQ(timeless(one), timeless(three));
}

TEST(Sweep, StoppedAndResumedEqualsWhole) {
  TrialTable whole(small_study());
  run_sweep(whole);

  TrialTable resumed(small_study());
  std::atomic<int> trials = 0;
  const SweepControl control{.on_trial = [&](const TrialRecord&) { ++trials; },
                             .stop_requested = [&] { return trials >= 5; }};
  tbb::task_arena(1).execute([&] { run_sweep(resumed, control); });
  EXPECT_EQ(resumed.filled(), 5u);
  EXPECT_EQ(trials, 5);
  run_sweep(resumed);
  EXPECT_TRUE(resumed.complete());
  EXPECT_EQ(timeless(resumed), timeless(whole));
}

TEST(Sweep, StartsWithOneTrialOfEveryCell) {
  TrialTable table(small_study());
  std::vector<std::uint32_t> trials;
  tbb::task_arena(1).execute(
      [&] { run_sweep(table, {.on_trial = [&](const TrialRecord& r) { trials.push_back(r.trial); }}); });
  EXPECT_EQ(trials, (std::vector<std::uint32_t>{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2}));
}

TEST(Sweep, PassesOnWhatTheCallbackThrows) {
  TrialTable table(small_study());
  EXPECT_THROW(run_sweep(table, {.on_trial = [](const TrialRecord&) { throw std::runtime_error("disk full"); }}),
               std::runtime_error);
}

TEST(TrialTable, RefusesRecordsOfAnotherStudy) {
  TrialTable table(small_study());
  const TrialRecord good{.solver = "tcf", .outlier_ratio = 0.5, .sigma = 1.0, .trial = 2, .seed = 7};
  for (const auto& spoil : std::vector<void (*)(TrialRecord&)>{
           [](TrialRecord& r) { r.solver = "other"; }, [](TrialRecord& r) { r.outlier_ratio = 0.51; },
           [](TrialRecord& r) { r.sigma = 2.0; }, [](TrialRecord& r) { r.trial = 3; },
           [](TrialRecord& r) { r.seed = 1; }}) {
    TrialRecord bad = good;
    spoil(bad);
    EXPECT_THROW(table.put(bad), std::invalid_argument);
  }
  table.put(good);
  table.put(good);
  EXPECT_EQ(table.filled(), 1u);
}

TEST(SweepOptions, DefaultIsThePapersStudy) {
  const SweepOptions options;
  EXPECT_NO_THROW(validate(options));
  EXPECT_EQ(options.points, std::vector<std::size_t>{3000});
  EXPECT_EQ(options.cells(), 250u);
  EXPECT_EQ(options.trials, 100u);
}

TEST(SweepOptions, RefusesBadValues) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const auto& spoil : std::vector<void (*)(SweepOptions&)>{
           [](SweepOptions& o) { o.points = {2}; }, [](SweepOptions& o) { o.trials = 0; },
           [](SweepOptions& o) { o.sigmas = {}; }, [](SweepOptions& o) { o.sigmas = {0.0}; },
           [](SweepOptions& o) { o.sigmas = {kNaN}; },
           [](SweepOptions& o) {
             o.sigmas = {1.0, 1.0};
           },
           [](SweepOptions& o) { o.outlier_ratios = {1.0}; }, [](SweepOptions& o) { o.outlier_ratios = {-0.1}; },
           [](SweepOptions& o) { o.outlier_ratios = {kNaN}; }, [](SweepOptions& o) { o.outlier_ratios = {0.9999}; },
           [](SweepOptions& o) { o.solvers = {"nonsense"}; },
           [](SweepOptions& o) {
             o.solvers = {"tcf", "tcf"};
           }}) {
    SweepOptions options;
    spoil(options);
    EXPECT_THROW(validate(options), std::invalid_argument);
  }
}

}  // namespace
}  // namespace consimd::studies
