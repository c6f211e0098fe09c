#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace consimd::synth {
namespace {

std::size_t inlier_count(const Problem& problem) {
  return static_cast<std::size_t>(std::ranges::count(problem.is_inlier, 1));
}

Eigen::Vector3d residual(const Problem& problem, std::size_t k) {
  return Eigen::Map<const Eigen::Vector3d>(&problem.target[3 * k]) -
         problem.T_target_source * Eigen::Map<const Eigen::Vector3d>(&problem.source[3 * k]);
}

void expect_same_bytes(const Problem& a, const Problem& b) {
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.target, b.target);
  EXPECT_EQ(a.is_inlier, b.is_inlier);
  EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
}

TEST(NoiseStudy, SameOptionsGiveSameBytes) {
  const NoiseStudyOptions options{.outlier_ratio = 0.5, .sigma = 2.5, .seed = 3, .trial = 99};
  expect_same_bytes(noise_study_problem(options), noise_study_problem(options));
}

TEST(NoiseStudy, EveryOptionOfACellGivesIndependentData) {
  const NoiseStudyOptions base{.correspondences = 100, .outlier_ratio = 0.5, .sigma = 1.0, .seed = 3, .trial = 4};
  std::set<double> first_coordinates;
  const auto draw = [&](auto change) {
    NoiseStudyOptions options = base;
    change(options);
    for (const double x : noise_study_problem(options).source) first_coordinates.insert(x);
  };
  draw([](NoiseStudyOptions&) {});
  draw([](NoiseStudyOptions& o) { o.correspondences = 101; });
  draw([](NoiseStudyOptions& o) { o.outlier_ratio = 0.51; });
  draw([](NoiseStudyOptions& o) { o.sigma = 1.01; });
  draw([](NoiseStudyOptions& o) { o.seed = 4; });
  draw([](NoiseStudyOptions& o) { o.trial = 5; });
  EXPECT_EQ(first_coordinates.size(), 3u * 601u);  // no coordinate is shared
}

TEST(NoiseStudy, RoundingOfAnOptionDoesNotChangeTheCell) {
  const NoiseStudyOptions exact{.correspondences = 100, .sigma = 0.3};
  NoiseStudyOptions summed = exact;
  summed.sigma = 0.1 + 0.1 + 0.1;
  ASSERT_NE(exact.sigma, summed.sigma);
  EXPECT_EQ(noise_study_problem(exact).source, noise_study_problem(summed).source);
}

TEST(NoiseStudy, CountOfInliersIsExact) {
  for (const auto& [n, ratio, expected] : {std::tuple{3000, 0.1, 2700},
                                           {3000, 0.5, 1500},
                                           {3000, 0.9, 300},
                                           {3000, 0.95, 150},
                                           {3000, 0.98, 60},
                                           {3000, 0.99, 30},
                                           {3000, 0.995, 15},
                                           {3, 0.0, 3},
                                           {10, 1.0, 0},
                                           {10, 0.25, 8},
                                           {1, 0.5, 1},
                                           {7, 0.9, 1}}) {
    const Problem problem =
        noise_study_problem({.correspondences = static_cast<std::size_t>(n), .outlier_ratio = ratio});
    EXPECT_EQ(problem.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(problem.source.size(), 3 * problem.size());
    EXPECT_EQ(problem.target.size(), 3 * problem.size());
    EXPECT_EQ(inlier_count(problem), static_cast<std::size_t>(expected)) << n << " at " << ratio;
  }
}

TEST(NoiseStudy, PoseIsARotationAndATranslationInTheCube) {
  Eigen::Vector3d extreme = Eigen::Vector3d::Zero();
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    const RigidTransform pose = noise_study_problem({.correspondences = 1, .trial = trial}).T_target_source;
    EXPECT_LT((pose.linear() * pose.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(pose.linear().determinant(), 0.0);
    extreme = extreme.cwiseMax(pose.translation().cwiseAbs());
  }
  EXPECT_LE(extreme.maxCoeff(), 100.0);
  EXPECT_GT(extreme.minCoeff(), 90.0);
}

TEST(NoiseStudy, SourcesAndOutlierTargetsAreUniformInTheCube) {
  const Problem problem = noise_study_problem({.correspondences = 20000, .outlier_ratio = 1.0, .half_extent = 50.0});
  for (const std::vector<double>* cloud : {&problem.source, &problem.target}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double low = 0.0, high = 0.0, sum = 0.0, squares = 0.0;
      for (std::size_t k = 0; k < problem.size(); ++k) {
        const double x = (*cloud)[3 * k + axis];
        low = std::min(low, x);
        high = std::max(high, x);
        sum += x;
        squares += x * x;
      }
      const auto n = static_cast<double>(problem.size());
      const double variance = 50.0 * 50.0 / 3.0;
      EXPECT_GE(low, -50.0);
      EXPECT_LE(high, 50.0);
      EXPECT_LT(low, -49.9);
      EXPECT_GT(high, 49.9);
      EXPECT_LT(std::abs(sum / n), 4.0 * std::sqrt(variance / n));
      EXPECT_NEAR(squares / n / variance, 1.0, 4.0 * std::sqrt(0.8 / n));  // kurtosis of the uniform: 1.8
    }
  }
}

TEST(NoiseStudy, LabelsTellInliersWithGaussianNoiseFromOutliers) {
  const double sigma = 0.5;
  const Problem problem = noise_study_problem({.correspondences = 20000, .outlier_ratio = 0.5, .sigma = sigma});
  EXPECT_EQ(problem.sigma, sigma);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
  std::size_t close_outliers = 0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Vector3d r = residual(problem, k);
    if (problem.is_inlier[k] == 0) {
      close_outliers += r.norm() < 6.0 * sigma;
      continue;
    }
    EXPECT_LT(r.norm(), 6.0 * sigma);
    sum += r;
    squares += r.cwiseAbs2();
  }
  EXPECT_LE(close_outliers, 5u);  // a ball of 3 m has 1.4e-5 of the cube's volume: 0.14 expected at most
  const double n = 10000.0;
  EXPECT_LT((sum / n).cwiseAbs().maxCoeff(), 4.0 * sigma / std::sqrt(n));
  EXPECT_LT((squares / n / (sigma * sigma) - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff(), 4.0 * std::sqrt(2.0 / n));
}

TEST(NoiseStudy, NoNoiseGivesExactInliers) {
  const Problem problem = noise_study_problem({.correspondences = 100, .outlier_ratio = 0.0, .sigma = 0.0});
  for (std::size_t k = 0; k < problem.size(); ++k) EXPECT_LT(residual(problem, k).norm(), 1e-12);
}

TEST(NoiseStudy, InliersAreARandomSubset) {
  constexpr std::size_t kRows = 10;
  constexpr int kTrials = 2000;
  std::array<int, kRows> chosen{};
  int both_first = 0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const Problem problem =
        noise_study_problem({.correspondences = kRows, .outlier_ratio = 0.5, .seed = 5, .trial = trial});
    for (std::size_t k = 0; k < kRows; ++k) chosen[k] += problem.is_inlier[k];
    both_first += problem.is_inlier[0] * problem.is_inlier[1];
  }
  for (const int count : chosen) EXPECT_NEAR(count, 0.5 * kTrials, 4.0 * std::sqrt(0.25 * kTrials));
  const double both = 5.0 / 10.0 * 4.0 / 9.0;
  EXPECT_NEAR(both_first, both * kTrials, 4.0 * std::sqrt(both * (1.0 - both) * kTrials));
}

TEST(NoiseStudy, CorrespondencesKeepTheRows) {
  const Problem problem = noise_study_problem({.correspondences = 65});
  const Correspondences correspondences = problem.correspondences();
  ASSERT_EQ(correspondences.size(), 65u);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x =
        correspondences.view().target(axis)[64] / correspondences.scale() + correspondences.target_centroid()[axis];
    EXPECT_NEAR(x, problem.target[3 * 64 + axis], 1e-4);
  }
}

TEST(NoiseStudy, BoundIsThreeSigma) { EXPECT_EQ(noise_study_bound(0.5), 1.5); }

TEST(NoiseStudy, BadOptionsAreNamed) {
  const auto message = [](const NoiseStudyOptions& options) -> std::string {
    try {
      static_cast<void>(noise_study_problem(options));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message({.outlier_ratio = 1.5}), "outlier_ratio = 1.5: expected a number in [0, 1]");
  EXPECT_EQ(message({.outlier_ratio = -0.25}), "outlier_ratio = -0.25: expected a number in [0, 1]");
  EXPECT_EQ(message({.outlier_ratio = nan}), "outlier_ratio = nan: expected a number in [0, 1]");
  EXPECT_EQ(message({.sigma = -1.0}), "sigma = -1: expected a finite number >= 0");
  EXPECT_EQ(message({.sigma = std::numeric_limits<double>::infinity()}), "sigma = inf: expected a finite number >= 0");
  EXPECT_EQ(message({.half_extent = 0.0}), "half_extent = 0: expected a finite number > 0");
  EXPECT_EQ(message({.correspondences = 0}), "correspondences = 0: expected 1 to 4294967295");
}

}  // namespace
}  // namespace consimd::synth
