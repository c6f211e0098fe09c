// Outliers that keep what a matcher sees: what is alike in each scene.
#include <consimd/synth/hard_problems.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace consimd::synth {
namespace {

/// Rows without a true pose: sources, and targets moved back into the frame of the first scene, without noise.
struct AlikePoints {
  Eigen::Matrix3Xd sources, targets;
};

AlikePoints alike_points(Scene scene, std::size_t parts, double half_extent = 100.0) {
  const Problem problem = hard_problem({.correspondences = 400,
                                        .outlier_ratio = 1.0,
                                        .sigma = 0.0,
                                        .half_extent = half_extent,
                                        .scene = scene,
                                        .thickness = 0.0,
                                        .parts = parts,
                                        .outliers = OutlierModel::alike});
  AlikePoints points;
  points.sources = Eigen::Map<const Eigen::Matrix3Xd>(problem.source.data(), 3, 400);
  points.targets = Eigen::Map<const Eigen::Matrix3Xd>(problem.target.data(), 3, 400);
  const RigidTransform back = problem.decoy_T_target_source.inverse();
  for (Eigen::Index k = 0; k < 400; ++k) points.targets.col(k) = back * points.targets.col(k);
  return points;
}

/// Singular values over the largest, which tell a line or a plane through the origin: roots of eigenvalues that are
/// exact to 1e-16, so zero is anything below kFlat.
constexpr double kFlat = 1e-6;
Eigen::Vector3d spread(const Eigen::Matrix3Xd& vectors) {
  const Eigen::Vector3d squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(vectors * vectors.transpose()).eigenvalues().cwiseMax(0.0);
  return (squares / squares[2]).cwiseSqrt();
}

Eigen::Matrix3Xd about_the_mean(const Eigen::Matrix3Xd& points) { return points.colwise() - points.rowwise().mean(); }

TEST(AlikeOutliers, OfAVolumeKeepTheDistance) {
  const AlikePoints alike = alike_points(Scene::volume, 1);
  EXPECT_LT((alike.sources.colwise().norm() - alike.targets.colwise().norm()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_GT(spread(alike.targets - alike.sources)[0], 0.5);
}

TEST(AlikeOutliers, StayOnTheirRing) {
  const AlikePoints alike = alike_points(Scene::rings, 7);
  const Eigen::RowVectorXd ranges = alike.sources.colwise().norm();
  EXPECT_LT((ranges - alike.targets.colwise().norm()).cwiseAbs().maxCoeff(), 1e-9);
  std::set<long> rings;
  for (const double range : ranges) rings.insert(std::lround(1e6 * range));
  EXPECT_EQ(rings.size(), 7u);
  EXPECT_NEAR(ranges.maxCoeff(), 2.0 / std::sin(3.0 * std::acos(-1.0) / 180.0), 1e-9);  // the flattest beam
  // All on the ground, 2 m below the scanner.
  const Eigen::Matrix3d scatter = about_the_mean(alike.sources) * about_the_mean(alike.sources).transpose();
  const Eigen::Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  EXPECT_LT(((up.transpose() * alike.sources).cwiseAbs().array() - 2.0).abs().maxCoeff(), 1e-9);
  EXPECT_LT((up.transpose() * (alike.targets - alike.sources)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(AlikeOutliers, OfPolesKeepTheHeight) {
  const AlikePoints alike = alike_points(Scene::poles, 1);
  EXPECT_LT(spread(about_the_mean(alike.sources))[1], kFlat);
  EXPECT_LT(spread(about_the_mean(alike.targets))[1], kFlat);
  // From pole to pole, always by the same step across.
  EXPECT_LT(about_the_mean(alike.targets - alike.sources).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::Vector3d along = (alike.sources.col(1) - alike.sources.col(0)).normalized();
  EXPECT_LT(std::abs(along.dot(alike.targets.col(0) - alike.sources.col(0))), 1e-9);
  EXPECT_GT((alike.targets.col(0) - alike.sources.col(0)).norm(), 1.0);
}

TEST(AlikeOutliers, OfALineAreOnTheOtherLine) {
  const AlikePoints alike = alike_points(Scene::lines, 1);
  EXPECT_LT(spread(about_the_mean(alike.sources))[1], kFlat);
  EXPECT_LT(spread(about_the_mean(alike.targets))[1], kFlat);
  EXPECT_GT(spread(alike.targets - alike.sources)[1], 1e-3);
}

TEST(AlikeOutliers, KeepThePlaceInACorridorsCrossSection) {
  const AlikePoints alike = alike_points(Scene::corridor, 1);
  EXPECT_LT(spread(alike.targets - alike.sources)[1], kFlat);
  EXPECT_GT((alike.targets - alike.sources).colwise().norm().maxCoeff(), 100.0);
  EXPECT_NEAR(spread(alike.sources)[1], 0.1, 0.05);
}

TEST(AlikeOutliers, StayOnTheirFaceOfARoom) {
  const AlikePoints alike = alike_points(Scene::room, 1);
  const Eigen::Matrix3Xd steps = (alike.targets - alike.sources).colwise().normalized();
  // Normals of faces: orthogonal to the steps on the face and the one across the room.
  std::vector<Eigen::Vector3d> normals;
  for (Eigen::Index i = 0; i < 40; ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const Eigen::Vector3d normal = steps.col(i).cross(steps.col(j)).normalized();
      if (((normal.transpose() * steps).array().abs() < 1e-6).count() > 12) normals.push_back(normal);
    }
  }
  ASSERT_FALSE(normals.empty());
  for (Eigen::Index k = 0; k < steps.cols(); ++k) {
    EXPECT_TRUE(
        std::ranges::any_of(normals, [&](const auto& normal) { return std::abs(normal.dot(steps.col(k))) < 1e-6; }));
  }
}

TEST(AlikeOutliers, AreWholeStepsAwayInAFacadeAndAGrid) {
  for (const Scene scene : {Scene::facade, Scene::grid}) {
    const AlikePoints alike = alike_points(scene, 10, 15.0);  // 3 m apart
    const Eigen::Matrix3Xd steps = (alike.targets - alike.sources) / 3.0;
    EXPECT_GT(steps.colwise().norm().maxCoeff(), 3.0);
    for (const double squared : steps.colwise().squaredNorm()) EXPECT_NEAR(squared, std::round(squared), 1e-9);
    EXPECT_EQ(spread(steps)[0] < kFlat, scene == Scene::facade);
  }
}

TEST(AlikeOutliers, OfAPlaneAndARodStayOnThem) {
  for (const Scene scene : {Scene::planar, Scene::linear}) {
    const AlikePoints alike = alike_points(scene, 1);
    Eigen::Matrix3Xd both(3, 800);
    both << alike.sources, alike.targets;
    EXPECT_LT(spread(about_the_mean(both))[scene == Scene::planar ? 0 : 1], kFlat);
    EXPECT_GT((alike.targets - alike.sources).colwise().norm().minCoeff(), 1e-6);
  }
}

}  // namespace
}  // namespace consimd::synth
