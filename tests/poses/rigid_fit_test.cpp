#include <consimd/poses/rigid_fit.hpp>

#include <consimd/kernels/rigid_moments.hpp>

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace consimd::test {
namespace {

Eigen::Matrix3Xd random_points(Eigen::Index n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-100.0, 100.0);
  return Eigen::Matrix3Xd::NullaryExpr(3, n, [&] { return coordinate(random); });
}

Correspondences correspondences_of(const Eigen::Matrix3Xd& p, const Eigen::Matrix3Xd& q) {
  return {PointSpan<double>::interleaved(p.data(), static_cast<std::size_t>(p.cols())),
          PointSpan<double>::interleaved(q.data(), static_cast<std::size_t>(q.cols()))};
}

RigidFit fit_all(const Correspondences& c) {
  const std::vector<std::uint64_t> bits(c.view().words(), ~std::uint64_t{0});
  std::vector<std::uint64_t> present = bits;
  if (c.size() % 64 != 0) present.back() = (std::uint64_t{1} << (c.size() % 64)) - 1;
  return rigid_fit(subset_moments(c, present));
}

RigidTransform any_transform() {
  RigidTransform T = RigidTransform::Identity();
  T.linear() = Eigen::Quaterniond(0.1, 0.6, -0.5, 0.4).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(4e6, 5e6, -70.0);
  return T;
}

TEST(RigidFit, RecoversAKnownPoseInTheCallersFrame) {
  const RigidTransform truth = any_transform();
  for (const Eigen::Index n : {3, 4, 65, 3000}) {
    const Eigen::Matrix3Xd p = random_points(n, 1);
    const Eigen::Matrix3Xd q = truth * p;
    const Correspondences c = correspondences_of(p, q);
    const RigidFit fit = fit_all(c);
    ASSERT_TRUE(fit.determined()) << n;
    const RigidTransform T = to_caller_frame(fit.pose, c);
    EXPECT_LT((T.linear() - truth.linear()).norm(), 2e-6);
    EXPECT_LT((T * p - q).colwise().norm().maxCoeff(), 2e-4);
    EXPECT_NEAR(T.linear().determinant(), 1.0, 1e-12);
    EXPECT_LT((to_working_frame(T, c).matrix() - fit.pose.matrix()).norm(), 1e-9);
  }
}

TEST(RigidFit, OfAMirroredCloudIsAProperRotation) {
  const Eigen::Matrix3Xd p = random_points(100, 2);
  Eigen::Matrix3Xd q = p;
  q.row(2) *= -1.0;
  const RigidFit fit = fit_all(correspondences_of(p, q));
  EXPECT_NEAR(fit.pose.linear().determinant(), 1.0, 1e-12);
  EXPECT_LT(fit.singular_values[2], 0.0);
  EXPECT_TRUE(fit.determined());
}

TEST(RigidFit, OfAPlaneIsDetermined) {
  Eigen::Matrix3Xd p = random_points(50, 3);
  p.row(2).setZero();
  const Eigen::Matrix3Xd q = any_transform() * p;
  const RigidFit fit = fit_all(correspondences_of(p, q));
  EXPECT_TRUE(fit.determined());
  EXPECT_LT((fit.pose.linear() - any_transform().linear()).norm(), 2e-6);
  EXPECT_NEAR(fit.pose.linear().determinant(), 1.0, 1e-12);
}

TEST(RigidFit, OfALineOrOnePointIsNotDetermined) {
  const Eigen::Matrix3Xd line = Eigen::Vector3d(1.0, 2.0, -0.7) * Eigen::RowVectorXd::LinSpaced(80, -50.0, 30.0);
  EXPECT_FALSE(fit_all(correspondences_of(line, any_transform() * line)).determined());
  const Eigen::Matrix3Xd point = Eigen::Vector3d(1.0, 2.0, -0.7) * Eigen::RowVectorXd::Ones(80);
  EXPECT_FALSE(fit_all(correspondences_of(point, any_transform() * point)).determined());
  const Eigen::Matrix3Xd two = random_points(2, 4);
  EXPECT_FALSE(fit_all(correspondences_of(two, any_transform() * two)).determined());

  const RigidFit none = rigid_fit(RigidMoments{});
  EXPECT_FALSE(none.determined());
  EXPECT_TRUE(none.pose.isApprox(RigidTransform::Identity()));
}

TEST(RigidFit, OfALineAwayFromTheOriginIsNotDetermined) {
  // the line is a small subset: its moments are dominated by its distance from the centroid of all
  Eigen::Matrix3Xd p = random_points(400, 5);
  for (Eigen::Index k = 0; k < 40; ++k) {
    p.col(k) = Eigen::Vector3d(80.0, 70.0, -90.0) + 0.05 * static_cast<double>(k) * Eigen::Vector3d(0.3, -0.5, 0.8);
  }
  const Eigen::Matrix3Xd q = any_transform() * p;
  const Correspondences c = correspondences_of(p, q);
  std::vector<std::uint64_t> bits(c.view().words(), 0);
  bits[0] = (std::uint64_t{1} << 40) - 1;
  EXPECT_FALSE(rigid_fit(subset_moments(c, bits)).determined());
}

TEST(WorkingPose, RoundTripsThroughSinglePrecision) {
  RigidTransform T = any_transform();
  T.translation() = Eigen::Vector3d(0.1, -0.7, 0.3);
  const RigidTransform back = from_working_pose(to_working_pose(T));
  EXPECT_LT((back.matrix() - T.matrix()).norm(), 3e-7);
  EXPECT_LT((back.linear() * back.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

}  // namespace
}  // namespace consimd::test
