// Searches that are ended early, and calls that bring their own threads.
#include <consimd/solvers/maximal_cliques.hpp>
#include <consimd/solvers/maximum_clique.hpp>
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/stop_condition.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/solvers/threads.hpp>
#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kNoiseBound = 3.0;

/// Days: what no search here takes, even under sanitizers.
StopCondition never_in_time() { return stop_after(1e6); }

Problem problem_with(double outlier_ratio, std::size_t rows = 1000) {
  return synth::hard_problem({.correspondences = rows, .outlier_ratio = outlier_ratio});
}

/// More samples than any machine draws in an hour.
RansacOptions endless() {
  return {.noise_bound = kNoiseBound, .max_iterations = 4'000'000'000, .confidence = std::nullopt};
}

TEST(StopCondition, IsMetByFlagOrDeadline) {
  EXPECT_FALSE(StopCondition().met());
  std::atomic<bool> flag = false;
  const StopCondition by_flag{.requested = &flag};
  EXPECT_FALSE(by_flag.met());
  flag = true;
  EXPECT_TRUE(by_flag.met());
  EXPECT_TRUE((StopCondition{.deadline = Clock::now()}).met());
  EXPECT_FALSE(never_in_time().met());
}

TEST(StopCondition, TakesAnySeconds) {
  EXPECT_TRUE(stop_after(0.0).met());
  EXPECT_TRUE(stop_after(-1.0).met());
  EXPECT_TRUE(stop_after(-kInfinity).met());
  EXPECT_FALSE(stop_after(1e9).met());
  for (const double never : {1e300, kInfinity, kNan}) {
    EXPECT_FALSE(stop_after(never).met());
    EXPECT_EQ(stop_after(never).deadline, Clock::time_point::max());
  }
}

class Stopping : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Solvers, Stopping, ::testing::ValuesIn(solver_names()), [](const auto& test) {
  std::string name = test.param;
  std::ranges::replace_if(
      name, [](char c) { return c == '-'; }, '_');
  return name;
});

TEST_P(Stopping, ConditionsThatAreNotMetChangeNothing) {
  const Problem problem = problem_with(0.5);
  const Correspondences correspondences = problem.correspondences();
  const std::atomic<bool> flag = false;
  StopCondition stop = never_in_time();
  stop.requested = &flag;
  const Registration without = register_by_name(GetParam(), correspondences, {.noise_bound = kNoiseBound});
  const Registration with = register_by_name(GetParam(), correspondences, {.noise_bound = kNoiseBound, .stop = stop});
  EXPECT_FALSE(with.stopped);
  EXPECT_EQ(with.status, without.status);
  EXPECT_EQ(with.inliers, without.inliers);
  EXPECT_EQ(with.T_target_source.matrix(), without.T_target_source.matrix());
}

TEST_P(Stopping, BeforeTheSearchThereIsNoPose) {
  const Problem problem = problem_with(0.5);
  const std::atomic<bool> flag = true;
  // The first cliques are looked at before the condition.
  const bool begins = GetParam() == "mac" || GetParam() == "teaser";
  for (const std::optional<double> noise_bound : {std::optional(kNoiseBound), std::optional<double>()}) {
    const Registration result = register_by_name(GetParam(), problem.correspondences(),
                                                 {.noise_bound = noise_bound, .stop = {.requested = &flag}});
    EXPECT_TRUE(result.stopped || begins);
    EXPECT_FALSE(result.has_pose() && !begins) << to_string(result.status);
    EXPECT_FALSE(result.stopped && result.status == Status::success);
  }
}

// Wherever the deadline falls there is a sound result: none that says more than was found.
TEST_P(Stopping, AnywhereTheResultIsSound) {
  const Problem problem = problem_with(0.9);
  const Correspondences correspondences = problem.correspondences();
  for (const double milliseconds : {0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0}) {
    const Registration result = register_by_name(GetParam(), correspondences,
                                                 {.noise_bound = kNoiseBound, .stop = stop_after(1e-3 * milliseconds)});
    SCOPED_TRACE(::testing::Message() << milliseconds << " ms");
    expect_sound(result, problem, kNoiseBound);
    EXPECT_FALSE(result.stopped && result.status == Status::success);
    if (!result.has_pose() || GetParam() == "tcf-published") continue;
    EXPECT_LT(synth::rotation_error_deg(result.T_target_source, problem.T_target_source), 5.0);
  }
}

TEST(StoppedSearch, GivesTheBestPoseSoFar) {
  const Problem problem = problem_with(0.5);
  RansacOptions options = endless();
  options.stop = stop_after(0.05);
  const Registration result = register_ransac(problem.correspondences(), options);
  EXPECT_TRUE(result.stopped);
  ASSERT_EQ(result.status, Status::budget_exhausted);
  expect_sound(result, problem, kNoiseBound);
  EXPECT_LT(synth::rotation_error_deg(result.T_target_source, problem.T_target_source), 1.0);
}

TEST(StoppedSearch, AnotherThreadMayEndIt) {
  const Problem problem = problem_with(0.5);
  std::atomic<bool> flag = false;
  RansacOptions options = endless();
  options.stop.requested = &flag;
  std::thread other([&flag] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    flag = true;
  });
  EXPECT_TRUE(register_ransac(problem.correspondences(), options).stopped);
  other.join();
}

TEST(StoppedSearch, OfRecurringPlacesSaysSo) {
  // Without a bound the rows that stand for others are searched once a solver has found nothing; that is when it ends.
  const Correspondences rows =
      synth::repeated_targets({.targets = 12, .frames = 6, .blunders = 7.0 / 12.0, .copied = false}).correspondences();
  std::atomic<bool> flag = false;
  SolverOptions options;
  options.stop.requested = &flag;
  const Registration result = register_with(
      [&flag](const Correspondences&, double noise_bound, std::uint32_t) {
        flag = true;
        Registration nothing;
        nothing.status = Status::no_consensus;
        nothing.noise_bound = noise_bound;
        return nothing;
      },
      rows, options);
  EXPECT_TRUE(result.stopped);
  EXPECT_NE(result.status, Status::success);
}

TEST(StoppedSearch, CliquesAreNotProven) {
  // Dense, and without a clique that stands out.
  const Problem problem = problem_with(1.0, 300);
  ConsistencyMatrix matrix;
  matrix.compute(problem.correspondences(), 40.0);
  const std::atomic<bool> flag = true;
  const MaximumClique greatest = maximum_clique(matrix, {.stop = {.requested = &flag}});
  EXPECT_FALSE(greatest.proven);
  EXPECT_EQ(greatest.nodes, 0u);
  EXPECT_TRUE(maximum_clique(matrix, {.stop = never_in_time()}).proven);
  const MaximalCliques all = maximal_cliques(matrix, {.min_size = 3, .stop = {.requested = &flag}});
  EXPECT_TRUE(all.cliques.empty());
  EXPECT_EQ(all.cut_short.size(), problem.size());
}

TEST_P(Stopping, ThreadsNeedNoArenaOfTheCaller) {
  const Problem problem = problem_with(0.5);
  const Correspondences correspondences = problem.correspondences();
  const Registration expected = register_by_name(GetParam(), correspondences, {.noise_bound = kNoiseBound});
  for (const int threads : {1, 2, 1000}) {
    const Registration result =
        register_by_name(GetParam(), correspondences, {.noise_bound = kNoiseBound, .threads = threads});
    EXPECT_EQ(result.threads, std::min(threads, tbb::info::default_concurrency()));
    EXPECT_EQ(result.inliers, expected.inliers);
    EXPECT_EQ(result.T_target_source.matrix(), expected.T_target_source.matrix());
  }
  expect_rejected(
      [&] {
        static_cast<void>(register_by_name(GetParam(), correspondences, {.noise_bound = kNoiseBound, .threads = -1}));
      },
      "threads", -1);
}

TEST(Threads, TheCallersArenaIsTheDefault) {
  tbb::task_arena(1).execute([] {
    run_on_threads(0, [] { EXPECT_EQ(tbb::this_task_arena::max_concurrency(), 1); });
    run_on_threads(
        2, [] { EXPECT_EQ(tbb::this_task_arena::max_concurrency(), std::min(2, tbb::info::default_concurrency())); });
  });
  EXPECT_THROW(run_on_threads(1, [] { throw std::runtime_error("of the body"); }), std::runtime_error);
  const Problem problem = problem_with(0.5);
  EXPECT_EQ(register_tcf(problem.correspondences(), {.noise_bound = kNoiseBound, .threads = 1}).threads, 1);
}

}  // namespace
}  // namespace consimd::test
