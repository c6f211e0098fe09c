#include <consimd/solvers/advice.hpp>
#include <consimd/solvers/assumed_inliers.hpp>
#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <vector>

#include <Eigen/Dense>

#include "problems.hpp"

namespace consimd::test {
namespace {

Problem targets(std::size_t count, double sigma, std::uint64_t trial) {
  return synth::hard_problem({.correspondences = count,
                              .outlier_ratio = 0.0,
                              .sigma = sigma,
                              .half_extent = 30.0,
                              .trial = trial,
                              .source_offset = {4.5e5, 5.4e6, 120.0}});
}

TEST(AssumedInliers, AreFittedByLeastSquares) {
  for (std::uint64_t trial = 0; trial < trials(200); ++trial) {
    const Problem problem = targets(3 + trial % 20, 0.01, trial);
    const AssumedInliers result = register_assumed_inliers(problem.correspondences());
    ASSERT_EQ(result.registration.status, Status::success);
    EXPECT_EQ(result.registration.inliers, all_rows(problem));
    const double rounding = 30.0 * 0x1p-22;
    EXPECT_LT(displacement(problem, result.registration.T_target_source, synth::oracle(problem)), rounding);
    double squares = 0.0;
    for (std::size_t k = 0; k < problem.size(); ++k) {
      EXPECT_NEAR(result.residuals[k], residual(problem, result.registration.T_target_source, k), rounding);
      squares += result.residuals[k] * result.residuals[k];
    }
    EXPECT_NEAR(result.sigma, std::sqrt(squares / (3.0 * static_cast<double>(problem.size()) - 6.0)), rounding);
    EXPECT_EQ(result.registration.noise_bound, *std::max_element(result.residuals.begin(), result.residuals.end()));
  }
}

TEST(AssumedInliers, HaveACovarianceThatTheirErrorsFollow) {
  // The squared error of the target centre in its own deviations has mean 3; of few rows it follows Hotelling's law.
  constexpr std::uint64_t kTrials = trials(1000);
  double sum = 0.0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const Problem problem = targets(60, 0.01, trial);
    const AssumedInliers result = register_assumed_inliers(problem.correspondences());
    const RigidTransform& pose = result.registration.T_target_source;
    Eigen::Vector3d source_centre = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < problem.size(); ++k) source_centre += source_point(problem, k) / 60.0;
    const Eigen::Vector3d error = problem.T_target_source * source_centre - pose * source_centre;
    const double variance = result.sigma * result.sigma / 60.0;
    sum += error.squaredNorm() / variance;
    const Eigen::Matrix3d rotation = result.registration.covariance.topLeftCorner<3, 3>();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(rotation).eigenvalues()[0], 0.0);
  }
  EXPECT_NEAR(sum / static_cast<double>(kTrials), 3.0, kAllTrials ? 0.4 : 3.0);
}

TEST(AssumedInliers, CornersOfARectangleAndThreeTargetsDo) {
  const std::vector<double> source{0, 0, 0, 4, 0, 0, 4, 3, 0, 0, 3, 0};
  const std::vector<double> target{1, 1, 1, 1, 5, 1, -2, 5, 1, -2, 1, 1};
  for (const std::size_t rows : {4U, 3U}) {
    const Correspondences corners(PointSpan<double>::interleaved(source.data(), rows),
                                  PointSpan<double>::interleaved(target.data(), rows));
    const AssumedInliers result = register_assumed_inliers(corners);
    ASSERT_EQ(result.registration.status, Status::success);
    Eigen::Matrix4d truth;
    truth << 0, -1, 0, 1, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 1;
    EXPECT_LT((result.registration.T_target_source.matrix() - truth).norm(), 1e-6);
    EXPECT_GT(result.registration.T_target_source.linear().determinant(), 0.0);
    EXPECT_LT(result.sigma, 1e-6);
  }
}

TEST(AssumedInliers, ThatLieOnALineOrCoincideAreNamed) {
  const auto of = [](const std::vector<double>& source, const std::vector<double>& target) {
    return register_assumed_inliers(Correspondences(PointSpan<double>::interleaved(source.data(), source.size() / 3),
                                                    PointSpan<double>::interleaved(target.data(), target.size() / 3)));
  };
  const std::vector<double> line{0, 0, 0, 1, 2, 3, 2, 4, 6, 3, 6, 9};
  const std::vector<double> corner{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::vector<double> point(12, 5.0);
  for (const auto& [source, target, geometry] :
       {std::tuple(line, line, PointGeometry::collinear), std::tuple(corner, line, PointGeometry::collinear),
        std::tuple(point, corner, PointGeometry::coincident), std::tuple(corner, point, PointGeometry::coincident)}) {
    const AssumedInliers result = of(source, target);
    EXPECT_EQ(result.registration.status, Status::degenerate_geometry);
    EXPECT_GE(result.geometry, geometry) << to_string(result.geometry);
    EXPECT_TRUE(result.residuals.empty() && result.registration.inliers.empty());
  }
  EXPECT_EQ(of(line, line).geometry, PointGeometry::collinear);
  EXPECT_EQ(of({0, 0, 0, 1, 1, 1}, {0, 0, 0, 1, 1, 1}).registration.status, Status::too_few_correspondences);
}

TEST(AssumedInliers, OfAnotherScaleOrAMirrorImageAreNamed) {
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    for (const double scale : {0.001, 0.98, 1.25, 1000.0}) {
      const Problem scaled = synth::hard_problem({.correspondences = 4 + trial % 9,
                                                  .outlier_ratio = 0.0,
                                                  .sigma = 0.002 * scale,
                                                  .half_extent = 10.0 * scale,
                                                  .trial = trial,
                                                  .scale = scale});
      const AssumedInliers found = register_assumed_inliers(scaled.correspondences());
      // A pose at a scale that is far off is none.
      const bool near = scale > 0.5 && scale < 2.0;
      EXPECT_EQ(found.registration.status, near ? Status::success : Status::degenerate_geometry)
          << scale << " trial " << trial;
      ASSERT_TRUE(found.other_scale.has_value()) << scale << " trial " << trial;
      EXPECT_NEAR(*found.other_scale / scale, 1.0, 0.005);
      EXPECT_FALSE(found.registration.mirrored);
      EXPECT_EQ(advice(found).size(), 1U);
    }
    const synth::HardProblemOptions options{
        .correspondences = 5 + trial % 9, .outlier_ratio = 0.0, .sigma = 0.002, .half_extent = 10.0, .trial = trial};
    const AssumedInliers plain = register_assumed_inliers(synth::hard_problem(options).correspondences());
    EXPECT_FALSE(plain.registration.mirrored || plain.other_scale.has_value());
    EXPECT_TRUE(advice(plain).empty());
    synth::HardProblemOptions reversed = options;
    reversed.mirrored = true;
    const AssumedInliers mirrored = register_assumed_inliers(synth::hard_problem(reversed).correspondences());
    EXPECT_TRUE(mirrored.registration.mirrored) << "trial " << trial;
    EXPECT_FALSE(mirrored.other_scale.has_value());
  }
}

TEST(AssumedInliers, ThatAreInAnotherOrderFitNoMotion) {
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    Problem problem = targets(5 + trial % 20, 0.01, trial);
    std::rotate(problem.target.begin(), problem.target.begin() + 3 * static_cast<std::ptrdiff_t>(problem.size() / 2),
                problem.target.end());
    const AssumedInliers found = register_assumed_inliers(problem.correspondences());
    // Few points in another order half fit a motion, which their residuals show.
    if (found.geometry == PointGeometry::determined) {
      EXPECT_LT(problem.size(), 8U);
      EXPECT_GT(found.sigma, 1.0) << "trial " << trial;
      continue;
    }
    EXPECT_EQ(found.geometry, PointGeometry::contradictory) << "trial " << trial;
    EXPECT_EQ(found.registration.status, Status::degenerate_geometry);
    EXPECT_EQ(advice(found).size(), 1U);
  }
}

TEST(AssumedInliers, OneOfWhichIsWrongTellWhich) {
  for (std::uint64_t trial = 0; trial < trials(1000); ++trial) {
    Problem problem = targets(5 + trial % 40, 0.01, trial);
    // Noise alone looks like that in less than one of 4000.
    EXPECT_FALSE(register_assumed_inliers(problem.correspondences()).odd_row.has_value()) << "trial " << trial;
    const std::size_t row = trial % problem.size();
    problem.target[3 * row + trial % 3] += trial % 2 == 0 ? 8.0 : -2000.0 * 0.01;
    const AssumedInliers found = register_assumed_inliers(problem.correspondences());
    EXPECT_EQ(found.odd_row, row) << "trial " << trial;
    EXPECT_EQ(advice(found).size(), 1U);
  }
}

TEST(AssumedInliers, MayNotBeFarFromAllOthers) {
  const Problem problem = synth::with_far_rows(targets(12, 0.01, 3), {.rows = 1, .distance = 1e9});
  EXPECT_THROW(static_cast<void>(register_assumed_inliers(problem.correspondences())), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
