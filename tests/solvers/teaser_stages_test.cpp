// Adaptive voting and graduated non-convexity.
#include <consimd/solvers/adaptive_voting.hpp>
#include <consimd/solvers/gnc_rotation.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <ostream>
#include <random>
#include <span>
#include <stdexcept>
#include <vector>

#include "problems.hpp"

namespace consimd {

void PrintTo(GncRotationOptions::Pairs pairs, std::ostream* out) {
  *out << (pairs == GncRotationOptions::Pairs::all ? "all" : "chain");
}

namespace test {
namespace {

double truncated_cost(std::span<const double> values, std::span<const double> bounds, double x) {
  double cost = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    cost += std::min(std::pow((values[i] - x) / bounds[i], 2), 1.0);
  }
  return cost;
}

TEST(AdaptiveVoting, FindsTheLeastCost) {
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) * 0x1p-32; };
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> values;
    std::vector<double> bounds;
    for (int i = 0; i < 30; ++i) {
      values.push_back(1e3 + 10.0 * uniform());
      bounds.push_back(0.2 + uniform());
    }
    const AdaptiveVote vote = adaptive_voting(values, bounds);
    EXPECT_NEAR(vote.cost, truncated_cost(values, bounds, vote.value), 1e-9);
    for (double x = 1e3 - 1.0; x < 1e3 + 11.0; x += 1e-3)
      EXPECT_GE(truncated_cost(values, bounds, x), vote.cost - 1e-9);
    for (const std::uint32_t i : vote.consensus) EXPECT_LT(i, values.size());
    EXPECT_TRUE(std::ranges::is_sorted(vote.consensus, std::ranges::less_equal{}));
  }
}

TEST(AdaptiveVoting, IsTheWeightedMeanOfThoseThatAgree) {
  const std::vector<double> values{5.0, 5.3, 100.0, -7.0, 4.9};
  const std::vector<double> bounds{1.0, 0.5, 1.0, 1.0, 1.0};
  const AdaptiveVote vote = adaptive_voting(values, bounds);
  EXPECT_NEAR(vote.value, (5.0 + 4.0 * 5.3 + 4.9) / 6.0, 1e-12);
  EXPECT_EQ(vote.consensus, (std::vector<std::uint32_t>{0, 1, 4}));
}

TEST(AdaptiveVoting, HandlesFewAndEqualMeasurements) {
  EXPECT_TRUE(adaptive_voting({}, {}).consensus.empty());
  EXPECT_EQ(adaptive_voting(std::vector{3.0}, std::vector{0.1}).value, 3.0);
  const std::vector<double> equal(100, -2.5);
  const AdaptiveVote vote = adaptive_voting(equal, std::vector<double>(100, 1e-6));
  EXPECT_EQ(vote.value, -2.5);
  EXPECT_EQ(vote.consensus.size(), 100u);
  EXPECT_EQ(vote.cost, 0.0);
}

TEST(AdaptiveVoting, BadMeasurementsAreRejected) {
  EXPECT_THROW(static_cast<void>(adaptive_voting(std::vector{1.0}, {})), std::invalid_argument);
  for (const double bound : kBadLengths) {
    expect_rejected([&] { static_cast<void>(adaptive_voting(std::vector{1.0}, std::vector{bound})); }, "bound", bound);
  }
  for (const double value : {kNan, kInfinity}) {
    expect_rejected([&] { static_cast<void>(adaptive_voting(std::vector{value}, std::vector{1.0})); }, "value", value);
  }
}

class GncRotationPairs : public ::testing::TestWithParam<GncRotationOptions::Pairs> {};
INSTANTIATE_TEST_SUITE_P(Pairs, GncRotationPairs,
                         ::testing::Values(GncRotationOptions::Pairs::chain, GncRotationOptions::Pairs::all));

TEST_P(GncRotationPairs, ResistsOutliers) {
  // A tenth of the members are wrong: two tenths of the differences.
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.1, .sigma = 0.5, .trial = trial});
    const GncRotation result =
        gnc_rotation(problem.correspondences(), all_rows(problem), {.difference_bound = 3.0, .pairs = GetParam()});
    ASSERT_TRUE(result.determined);
    RigidTransform T = problem.T_target_source;
    T.linear() = result.rotation;
    expect_proper_rotation(T);
    EXPECT_LT(synth::rotation_error_deg(T, problem.T_target_source), 0.3);
    const bool all = GetParam() == GncRotationOptions::Pairs::all;
    EXPECT_EQ(result.measurements, all ? 200u * 199u / 2u : 200u);
    EXPECT_GT(static_cast<double>(result.inliers), 0.75 * static_cast<double>(result.measurements));
    EXPECT_LE(result.rounds, 100u);
  }
}

TEST_P(GncRotationPairs, IsExactWithoutNoise) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.0, .sigma = 0.0});
  const GncRotation result =
      gnc_rotation(problem.correspondences(), all_rows(problem), {.difference_bound = 1.0, .pairs = GetParam()});
  ASSERT_TRUE(result.determined);
  EXPECT_LT((result.rotation - problem.T_target_source.linear()).norm(), 1e-5);
  EXPECT_EQ(result.rounds, 0u);
  EXPECT_EQ(result.inliers, result.measurements);
}

TEST_P(GncRotationPairs, IsTheSameForAnyNumberOfThreads) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.3});
  const auto run = [&] {
    return gnc_rotation(problem.correspondences(), all_rows(problem), {.difference_bound = 6.0, .pairs = GetParam()});
  };
  const GncRotation expected = run();
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena(threads).execute([&] { EXPECT_EQ(run().rotation, expected.rotation); });
  }
}

TEST(GncRotation, IsNotDeterminedByPointsOnALine) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(20);
  for (int k = 0; k < 20; ++k) points.emplace_back(k, 2 * k, -k);
  const Problem line = perfect_problem(points, motion(1.0, {1.0, 0.0, 0.0}, {1.0, 2.0, 3.0}));
  EXPECT_FALSE(gnc_rotation(line.correspondences(), all_rows(line), {.difference_bound = 0.1}).determined);
  const std::vector<std::uint32_t> two{0, 1};
  EXPECT_FALSE(gnc_rotation(line.correspondences(), two, {.difference_bound = 0.1}).determined);
}

TEST(GncRotation, BadOptionsAreRejected) {
  const Problem problem = synth::noise_study_problem({.correspondences = 10});
  const auto run = [&](const GncRotationOptions& options) {
    return
        [&problem, options] { static_cast<void>(gnc_rotation(problem.correspondences(), all_rows(problem), options)); };
  };
  for (const double bound : kBadLengths) expect_rejected(run({.difference_bound = bound}), "difference_bound", bound);
  for (const double growth : {1.0, 0.5, kNan, kInfinity}) {
    expect_rejected(run({.difference_bound = 1.0, .growth = growth}), "growth", growth);
  }
  for (const double change : {-1.0, kNan}) {
    expect_rejected(run({.difference_bound = 1.0, .smallest_change = change}), "smallest_change", change);
  }
}

}  // namespace
}  // namespace test
}  // namespace consimd
