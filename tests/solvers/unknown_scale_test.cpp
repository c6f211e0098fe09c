// Scale, rotation and translation together: what holds for every solver that can find a scale.
#include <consimd/solvers/pcr99.hpp>
#include <consimd/solvers/scale_voting.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/teaser.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Cholesky>

#include <cmath>
#include <string>
#include <tuple>

#include "comparison.hpp"
#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

Problem with_scaled_source(Problem problem, double scale) {
  for (double& x : problem.source) x *= scale;
  problem.scale = 1.0;
  return problem;
}

Registration run(const std::string& solver, const Problem& problem, double noise_bound, std::uint64_t seed = 1) {
  Registration result = register_by_name(solver, problem.correspondences(),
                                         {.noise_bound = noise_bound, .seed = seed, .estimate_scale = true});
  EXPECT_GT(result.scale, 0.0);
  // At the scale it found, a result is sound as one of known scale.
  if (!result.runner_up || result.runner_up->scale == result.scale) {
    expect_sound(result, with_scaled_source(problem, result.scale), noise_bound);
  }
  return result;
}

class UnknownScale : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Solvers, UnknownScale, ::testing::Values("pcr99", "teaser"),
                         [](const auto& test) { return test.param; });

TEST_P(UnknownScale, IsFoundWithinAPercentAtNinetyPercentOutliers) {
  for (const double scale : {0.2, 0.5, 1.0, 2.0, 5.0}) {
    for (const double sigma : {0.1, 1.0}) {
      for (std::uint64_t trial = 0; trial < trials(2); ++trial) {
        SCOPED_TRACE(::testing::Message() << "scale " << scale << ", sigma " << sigma << ", trial " << trial);
        const Problem problem = synth::noise_study_problem(
            {.correspondences = 2000, .outlier_ratio = 0.9, .sigma = sigma, .trial = trial, .scale = scale});
        const Registration result = run(GetParam(), problem, 3.0 * sigma, trial);
        EXPECT_EQ(result.status, Status::success);
        EXPECT_NEAR(result.scale / scale, 1.0, 0.01);
        EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source, result.scale), 2.0 * sigma);
        ASSERT_GT(result.scale_deviation, 0.0);
        EXPECT_EQ(result.stages.front().name, "scale_voting");
        EXPECT_EQ(result.stages.back().name, "similarity");
      }
    }
  }
}

TEST(UnknownScaleDeviation, IsThatOfTheErrors) {
  double scale_squares = 0.0;
  double position_squares = 0.0;  // at the source's origin, which lies off the inliers
  double made = 0.0;
  for (std::uint64_t trial = 0; trial < trials(60); ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 400,
                                                 .outlier_ratio = 0.7,
                                                 .trial = trial,
                                                 .source_offset = {300.0, 200.0, -100.0},
                                                 .scale = 2.0});
    const Registration result = run("pcr99", problem, 3.0, trial);
    ASSERT_EQ(result.status, Status::success);
    scale_squares += std::pow((result.scale - problem.scale) / result.scale_deviation, 2.0);
    const Eigen::Vector3d error = problem.T_target_source.translation() - result.T_target_source.translation();
    const Eigen::Matrix3d covariance = result.covariance.bottomRightCorner<3, 3>();
    position_squares += error.dot(covariance.ldlt().solve(error)) / 3.0;
    ++made;
  }
  if (kAllTrials) {
    EXPECT_NEAR(scale_squares / made, 1.0, 0.5);
    EXPECT_NEAR(position_squares / made, 1.0, 0.35);
  }
}

TEST_P(UnknownScale, OutliersMayKeepTheirSize) {
  // A source of 100 m; targets of inliers shrink or grow, those of outliers fill the cube of the source.
  for (const double scale : {0.2, 5.0}) {
    Problem problem = synth::noise_study_problem({.correspondences = 2000, .outlier_ratio = 0.9, .sigma = 0.0});
    std::mt19937 random(3);
    for (std::size_t k = 0; k < problem.size(); ++k) {
      if (problem.is_inlier[k] == 0) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        double& x = problem.target[3 * k + axis];
        x = scale * x + 0.2 * (static_cast<double>(random()) * 0x1p-32 - 0.5);
      }
    }
    const Registration result = run(GetParam(), problem, 0.3);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_NEAR(result.scale / scale, 1.0, 0.01);
  }
}

TEST_P(UnknownScale, FewAndNoOutliers) {
  for (const double outlier_ratio : {0.0, 0.5}) {
    for (const std::size_t size : {30U, 500U}) {
      const Problem problem = synth::noise_study_problem(
          {.correspondences = size, .outlier_ratio = outlier_ratio, .sigma = 0.1, .scale = 3.0});
      const Registration result = run(GetParam(), problem, 0.3);
      EXPECT_EQ(result.status, Status::success) << size << " rows, " << outlier_ratio;
      EXPECT_NEAR(result.scale, 3.0, 0.03) << size << " rows, " << outlier_ratio;
    }
  }
}

TEST_P(UnknownScale, GivesNoPoseWhereThereIsNone) {
  for (const auto outliers : kOutlierModels) {
    for (const std::size_t size : {5U, 30U, 300U}) {
      for (std::uint64_t trial = 0; trial < trials(5); ++trial) {
        const Problem problem =
            synth::hard_problem({.correspondences = size, .outlier_ratio = 1.0, .trial = trial, .outliers = outliers});
        const Registration result = run(GetParam(), problem, 3.0, trial);
        EXPECT_FALSE(result.has_pose()) << size << " rows, trial " << trial << ", scale " << result.scale;
        EXPECT_EQ(result.scale, 1.0);
      }
    }
  }
}

TEST_P(UnknownScale, DegenerateInputHasNoPose) {
  const RigidTransform truth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  for (const std::size_t size : {0U, 1U, 2U, 3U, 200U}) {
    for (const Eigen::Vector3d& step : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.5, 1.0, -0.3)}) {
      std::vector<Eigen::Vector3d> points;
      for (std::size_t k = 0; k < size; ++k) points.emplace_back(static_cast<double>(k) * step);
      EXPECT_FALSE(run(GetParam(), perfect_problem(points, truth), 0.3).has_pose()) << size << " rows";
    }
  }
}

TEST_P(UnknownScale, TwoMotionsAreAmbiguous) {
  const Problem problem = synth::hard_problem(
      {.correspondences = 1000, .outlier_ratio = 0.7, .sigma = 0.1, .decoy_share = 1.0, .scale = 0.5});
  EXPECT_EQ(run(GetParam(), problem, 0.3).status, Status::ambiguous);
}

TEST_P(UnknownScale, HasTheSameBitsOnAnyNumberOfThreadsAndInstructionSet) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Isa before = active_isa();
  for (const double outlier_ratio : {0.3, 0.9, 1.0}) {
    const Problem problem =
        synth::hard_problem({.correspondences = 900, .outlier_ratio = outlier_ratio, .decoy_share = 0.2, .scale = 2.0});
    const Registration expected = run(GetParam(), problem, 3.0);
    const auto expect_again = [&] {
      const Registration result = run(GetParam(), problem, 3.0);
      expect_same(result, expected);
      EXPECT_EQ(result.scale, expected.scale);
      EXPECT_EQ(result.scale_deviation, expected.scale_deviation);
    };
    for (const int threads : {1, 2, 4}) tbb::task_arena(threads).execute(expect_again);
    for (const Isa isa : supported_isas()) {
      set_active_isa(isa);
      expect_again();
    }
    set_active_isa(before);
  }
}

TEST(UnknownScaleOfTeaser, OwnEstimateIsGivenWithoutRefinement) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.9, .scale = 2.0});
  const Registration result =
      register_teaser(problem.correspondences(), {.noise_bound = 3.0, .estimate_scale = true, .refine = false});
  EXPECT_EQ(result.status, Status::success);
  EXPECT_NEAR(result.scale, 2.0, 0.02);
  EXPECT_EQ(result.scale_deviation, 0.0);
  EXPECT_TRUE(result.covariance.isZero(0.0));
}

TEST(UnknownScaleErrors, SaySo) {
  const Correspondences some = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const auto message = [&](const std::string& solver, const SolverOptions& options) -> std::string {
    try {
      static_cast<void>(register_by_name(solver, some, options));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const Solver& info : solvers()) {
    const std::string text = message(info.name, {.noise_bound = 1.0, .estimate_scale = true});
    if (info.estimates_scale()) {
      EXPECT_EQ(text, "accepted") << info.name;
    } else {
      EXPECT_NE(text.find(std::string("'").append(info.name) + "' needs a known scale, expected one of: pcr99, teaser"),
                std::string::npos)
          << text;
    }
  }
  EXPECT_NE(message("pcr99", {.estimate_scale = true}).find("needs a noise_bound"), std::string::npos);
  EXPECT_NE(message("pcr99", {.noise_bound = 1.0, .filter = Filter::tcf, .estimate_scale = true}).find("filter 'tcf'"),
            std::string::npos);
}

TEST(ScaleVoting, StandsOutAndIsSampledWithinItsLimits) {
  const Problem problem = synth::noise_study_problem({.correspondences = 2000, .outlier_ratio = 0.9, .scale = 2.0});
  const Correspondences correspondences = problem.correspondences();
  for (const std::uint32_t most : {200U, 4096U}) {
    const auto scales =
        scale_voting(correspondences, {.noise_bound = 3.0, .max_voters = most, .max_partners = 2 * most});
    ASSERT_FALSE(scales.empty());
    EXPECT_NEAR(scales.front().scale, 2.0, 0.03);
    EXPECT_LE(scales.front().voters, most);
    EXPECT_GT(scales.front().measurements, 0u);
    for (std::size_t s = 1; s < scales.size(); ++s) EXPECT_LE(scales[s].votes, scales[s - 1].votes);
  }
  EXPECT_TRUE(scale_voting(Correspondences(), {.noise_bound = 3.0}).empty());
  for (const double length : kBadLengths) {
    expect_rejected([&] { static_cast<void>(scale_voting(correspondences, {.noise_bound = length})); }, "noise_bound",
                    length);
    expect_rejected(
        [&] { static_cast<void>(scale_voting(correspondences, {.noise_bound = 1.0, .tolerance = length})); },
        "tolerance", length);
  }
  expect_rejected([&] { static_cast<void>(scale_voting(correspondences, {.noise_bound = 1.0, .max_voters = 0})); },
                  "max_voters", 0.0);
}

}  // namespace
}  // namespace consimd::test
