#include <consimd/synth/metrics.hpp>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <consimd/synth/noise_study.hpp>

namespace consimd::synth {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

RigidTransform pose(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& translation) {
  RigidTransform result = RigidTransform::Identity();
  result.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  result.translation() = translation;
  return result;
}

TEST(RotationError, IsTheAngleFromTinyToHalfATurn) {
  const RigidTransform truth = pose(2.0, {1.0, -2.0, 0.5}, {4.0, 5.0, 6.0});
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.3, -0.8, 0.2)}) {
    for (const double angle : {1e-12, 1e-9, 1e-3, 1.0, 3.0, std::numbers::pi - 1e-9, std::numbers::pi}) {
      const RigidTransform estimate = pose(angle, axis, Eigen::Vector3d::Zero()) * truth;
      EXPECT_NEAR(rotation_error_deg(estimate, truth) * kDegree, angle, 2e-15) << angle;
      EXPECT_NEAR(rotation_error_deg(truth, estimate) * kDegree, angle, 2e-15) << angle;
    }
  }
  EXPECT_LT(rotation_error_deg(truth, truth), 1e-13);
}

TEST(TranslationError, IsTheDistance) {
  const RigidTransform a = pose(1.0, {0, 0, 1}, {1.0, 2.0, 3.0}), b = pose(2.0, {1, 0, 0}, {4.0, 6.0, 3.0});
  EXPECT_DOUBLE_EQ(translation_error(a, b), 5.0);
}

Problem four_rows() {
  Problem problem;
  problem.source = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  problem.target = {3, 0, 0, 1, 0, 4, 50, 50, 50, 0, 0, 1};
  problem.is_inlier = {1, 1, 0, 0};
  return problem;
}

TEST(RmseTrueInliers, CountsTrueInliersAlone) {
  EXPECT_DOUBLE_EQ(rmse_true_inliers(four_rows(), RigidTransform::Identity()), std::sqrt((9.0 + 16.0) / 2.0));
  EXPECT_DOUBLE_EQ(rmse_true_inliers(four_rows(), pose(0.0, {1, 0, 0}, {3.0, 0.0, 0.0})),
                   std::sqrt((0.0 + 25.0) / 2.0));
}

TEST(InlierQuality, SharesOfReportedAndOfTrue) {
  const std::vector<std::uint32_t> reported{0, 2, 3};
  const InlierQuality quality = inlier_quality(four_rows(), reported);
  EXPECT_DOUBLE_EQ(quality.precision, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(quality.recall, 0.5);
  const InlierQuality nothing = inlier_quality(four_rows(), {});
  EXPECT_TRUE(std::isnan(nothing.precision));
  EXPECT_EQ(nothing.recall, 0.0);
  const std::vector<std::uint32_t> outside{0, 4};
  EXPECT_THROW(static_cast<void>(inlier_quality(four_rows(), outside)), std::out_of_range);
}

TEST(Metrics, AreNanWithoutInliers) {
  const Problem problem = noise_study_problem({.correspondences = 10, .outlier_ratio = 1.0});
  const RigidTransform fit = oracle(problem);
  EXPECT_TRUE(std::isnan(rotation_error_deg(fit, problem.T_target_source)));
  EXPECT_TRUE(std::isnan(translation_error(fit, problem.T_target_source)));
  EXPECT_TRUE(std::isnan(rmse_true_inliers(problem, problem.T_target_source)));
  const std::vector<std::uint32_t> reported{1};
  EXPECT_EQ(inlier_quality(problem, reported).precision, 0.0);
  EXPECT_TRUE(std::isnan(inlier_quality(problem, reported).recall));
}

TEST(Oracle, IsExactWithoutNoise) {
  for (const std::size_t n : {3u, 4u, 10u, 1000u}) {
    const Problem problem = noise_study_problem({.correspondences = n, .outlier_ratio = 0.0, .sigma = 0.0});
    const RigidTransform fit = oracle(problem);
    EXPECT_LT(rotation_error_deg(fit, problem.T_target_source), 1e-12) << n;
    EXPECT_LT(translation_error(fit, problem.T_target_source), 1e-11) << n;
  }
}

TEST(Oracle, IsAMinimumAndProper) {
  const Problem problem = noise_study_problem({.correspondences = 200, .outlier_ratio = 0.9, .sigma = 5.0});
  const RigidTransform fit = oracle(problem);
  EXPECT_NEAR(fit.linear().determinant(), 1.0, 1e-12);
  const double least = rmse_true_inliers(problem, fit);
  EXPECT_LE(least, rmse_true_inliers(problem, problem.T_target_source));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-3, 1e-3}) {
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
      EXPECT_LT(least, rmse_true_inliers(problem, pose(0.0, unit, step * unit) * fit));
      EXPECT_LT(least, rmse_true_inliers(problem, pose(step, unit, Eigen::Vector3d::Zero()) * fit));
    }
  }
}

TEST(Oracle, NeverReflects) {
  Problem problem;
  problem.source = {1, 0, 0, 0, 1, 0, 0, 0, 1, -1, -1, -1};
  problem.target = {-1, 0, 0, 0, 1, 0, 0, 0, 1, 1, -1, -1};
  problem.is_inlier = {1, 1, 1, 1};
  EXPECT_NEAR(oracle(problem).linear().determinant(), 1.0, 1e-12);
}

/// Root mean square of the oracle's errors over trials: rotation vector in radians, translation in metres.
struct RmsErrors {
  double rotation;
  double translation;
};

RmsErrors oracle_errors(std::size_t inliers, double sigma, std::uint64_t trials) {
  double rotation = 0.0, translation = 0.0;
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    const Problem problem = noise_study_problem(
        {.correspondences = 2 * inliers, .outlier_ratio = 0.5, .sigma = sigma, .seed = 17, .trial = trial});
    const RigidTransform fit = oracle(problem);
    rotation += std::pow(rotation_error_deg(fit, problem.T_target_source) * kDegree, 2);
    translation += std::pow(translation_error(fit, problem.T_target_source), 2);
  }
  const auto n = static_cast<double>(trials);
  return {std::sqrt(rotation / n), std::sqrt(translation / n)};
}

// With n points of variance v per axis about the origin, information 2 n v / sigma^2 on each rotation axis and
// n / sigma^2 on each translation axis.
TEST(Oracle, ErrorsFollowTheory) {
  constexpr std::uint64_t kTrials = 100;
  const double v = 100.0 * 100.0 / 3.0;
  for (const std::size_t n : {30u, 300u, 1500u}) {
    for (const double sigma : {0.1, 1.0, 5.0}) {
      const RmsErrors errors = oracle_errors(n, sigma, kTrials);
      const auto count = static_cast<double>(n);
      // Sampling: a mean square over 3 x 100 normal variates has relative deviation sqrt(2 / 300), its root half of it.
      // The 1 / n terms of theory add at most 3 % to it at n = 30.
      const double limit = 4.0 * 0.5 * std::sqrt(2.0 / 300.0) + 1.0 / count;
      EXPECT_NEAR(errors.rotation / (sigma * std::sqrt(3.0 / (2.0 * count * v))), 1.0, limit) << n << " " << sigma;
      EXPECT_NEAR(errors.translation / (sigma * std::sqrt(3.0 / count)), 1.0, limit) << n << " " << sigma;
    }
  }
}

}  // namespace
}  // namespace consimd::synth
