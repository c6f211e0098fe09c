#include <consimd/studies/limits.hpp>

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <Eigen/Geometry>

#include <consimd/synth/hard_problems.hpp>

namespace consimd::studies {
namespace {

constexpr double kSigma = 5.0;

SweepOptions few_points() {
  SweepOptions options;
  options.points = {30};
  options.seed = 5;
  return options;
}

synth::Problem without_truth(std::uint64_t trial) {
  return synth::hard_problem({.correspondences = 30, .outlier_ratio = 1.0, .sigma = kSigma, .seed = 5, .trial = trial});
}

using Points = Eigen::Map<const Eigen::Matrix3Xd>;

std::size_t support(const synth::Problem& problem, const Eigen::Matrix4d& pose) {
  const Points source(problem.source.data(), 3, 30);
  const Points target(problem.target.data(), 3, 30);
  const Eigen::Matrix3Xd moved = (pose.topLeftCorner<3, 3>() * source).colwise() + pose.topRightCorner<3, 1>();
  return static_cast<std::size_t>(((moved - target).colwise().norm().array() < 3.0 * kSigma).count());
}

/// The largest support among the least-squares poses of all triples.
std::size_t best_support_of_triples(const synth::Problem& problem) {
  const Points source(problem.source.data(), 3, 30);
  const Points target(problem.target.data(), 3, 30);
  std::size_t best = 0;
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < i; ++j) {
      for (int k = 0; k < j; ++k) {
        const Eigen::Array3i rows(i, j, k);
        best = std::max(best, support(problem, Eigen::umeyama(Eigen::Matrix3d(source(Eigen::all, rows)),
                                                              Eigen::Matrix3d(target(Eigen::all, rows)), false)));
      }
    }
  }
  return best;
}

TEST(Limits, RowReadsBackToTheSameBits) {
  const LimitRecord record{.sigma = 0.1,
                           .problems = 10,
                           .chance_support_mean = 1.0 / 3.0,
                           .chance_support_max = 7,
                           .fixed_support_mean = 1e-300,
                           .limit_outlier_ratio = 0.1 + 0.2};
  const std::string row = to_csv_row(record);
  EXPECT_EQ(parse_limit_row(row.substr(0, row.size() - 1)), record);
  EXPECT_EQ(std::ranges::count(row, ','), std::ranges::count(csv_header(kLimitColumns), ','));
  for (const char* bad : {"", "1,2,3,4,5", "1,2,3,4,5,6,7", "1,2,3,x,5,6", "1,2.5,3,4,5,6"}) {
    EXPECT_THROW((void)parse_limit_row(bad), std::invalid_argument) << bad;
  }
}

// 0.970709 is the chi-square distribution with three degrees of freedom at 9, from tables.
TEST(Limits, TheTruePoseHasTheChanceSupportAtTheLimit) {
  for (const double chance : {3.0, 17.2, 200.0}) {
    for (const double fixed : {0.0, 2.5}) {
      const double ratio = limit_outlier_ratio(3000, chance, fixed);
      EXPECT_NEAR(3000.0 * (1.0 - ratio) * 0.970709 + ratio * fixed, chance, 2e-3);
    }
  }
}

TEST(Limits, LiesBetweenNoneAndAll) {
  EXPECT_EQ(limit_outlier_ratio(3000, 2950.0, 0.0), 0.0);
  EXPECT_EQ(limit_outlier_ratio(3000, 3000.0, 3000.0), 0.0);
  EXPECT_EQ(limit_outlier_ratio(3000, 3.0, 4.0), 1.0);
  EXPECT_EQ(limit_outlier_ratio(3, 3.0, 0.0), 0.0);
  EXPECT_EQ(limit_outlier_ratio(3000, 0.0, 0.0), limit_outlier_ratio(3000, 3.0, 0.0));
}

TEST(Limits, AgreesWithTryingEveryTriple) {
  double best = 0.0;
  double fixed = 0.0;
  for (std::uint32_t k = 0; k < kLimitProblems; ++k) {
    const synth::Problem problem = without_truth(k);
    best += static_cast<double>(best_support_of_triples(problem)) / kLimitProblems;
    fixed += static_cast<double>(support(problem, problem.T_target_source.matrix())) / kLimitProblems;
  }
  const std::optional<LimitRecord> limit = measure_limit(few_points(), kSigma);
  ASSERT_TRUE(limit);
  EXPECT_EQ(limit->sigma, kSigma);
  EXPECT_EQ(limit->problems, kLimitProblems);
  EXPECT_NEAR(limit->fixed_support_mean, fixed, 1e-12);
  // The search ranks poses by a score that a support's residuals enter, and refines them.
  EXPECT_NEAR(limit->chance_support_mean, best, 0.5);
  EXPECT_GE(static_cast<double>(limit->chance_support_max), limit->chance_support_mean);
  EXPECT_EQ(limit->limit_outlier_ratio, limit_outlier_ratio(30, limit->chance_support_mean, limit->fixed_support_mean));
}

TEST(Limits, GrowWithTheNoise) {
  const double low = measure_limit(few_points(), 1.0)->chance_support_mean;
  EXPECT_LT(low, measure_limit(few_points(), 20.0)->chance_support_mean);
}

TEST(Limits, DoNotDependOnTheNumberOfThreads) {
  const auto with_threads = [](int threads) {
    return tbb::task_arena(threads).execute([] { return measure_limit(few_points(), kSigma); });
  };
  EXPECT_EQ(with_threads(1), with_threads(3));
}

TEST(Limits, ReportProblemsAndStop) {
  std::atomic<std::uint32_t> problems = 0;
  const auto count = [&] { ++problems; };
  EXPECT_TRUE(measure_limit(few_points(), kSigma, {.on_problem = count}));
  EXPECT_EQ(problems, kLimitProblems);
  problems = 0;
  const LimitControl control{.on_problem = count, .stop_requested = [&] { return problems >= 4; }};
  EXPECT_FALSE(tbb::task_arena(1).execute([&] { return measure_limit(few_points(), kSigma, control); }));
  EXPECT_EQ(problems, 4);
}

}  // namespace
}  // namespace consimd::studies
