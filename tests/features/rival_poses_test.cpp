// Scenes that repeat themselves, and clouds of two scales: what no correspondence tells.
#include <consimd/features/cloud_verdict.hpp>
#include <consimd/features/pose_verification.hpp>
#include <consimd/features/register_clouds.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "scene.hpp"
#include "seen.hpp"
#include "street.hpp"

namespace consimd::test {
namespace {

using features::PoseEvidence;
using features::PoseVerifier;

constexpr double kPeriod = 10.0;
constexpr double kByCorrespondences = -30.0;

/// How far a pose is from a shift by whole houses, with the scene turned by half a circle or not.
double from_a_whole_house(const RigidTransform& pose, const RigidTransform& right) {
  const RigidTransform between = pose * right.inverse();
  const double across = std::hypot(between.translation().y(), between.translation().z());
  EXPECT_GT(between.linear()(2, 2), 0.99);
  EXPECT_GT(std::abs(between.linear()(0, 0)), 0.99);
  if (between.linear()(0, 0) < 0.0) return across;  // where a scene turned round repeats depends on where it stands
  return std::hypot(across, std::remainder(between.translation().x(), kPeriod));
}

TEST(RivalPoses, ARowOfLikeHousesHasOneSomeHousesFurther) {
  const Seen source(scan_of(like_houses(kPeriod), 3.0, 0.0, 1)), target(scan_of(like_houses(kPeriod), 0.0, 0.0, 2));
  const RigidTransform right = between_scans(3.0, 0.0, 0.0, 0.0);
  for (const double houses : {0.0, 1.0, -1.0}) {
    const PoseEvidence found = evidence(source, target, between_scans(3.0 + houses * kPeriod, 0.0, 0.0, 0.0));
    ASSERT_TRUE(found.rival) << houses;
    EXPECT_TRUE(features::has_equal_rival(found)) << houses << " " << found.rival->share_of_score;
    EXPECT_LT(from_a_whole_house(found.rival->T_target_source, right), 0.5) << houses;
    EXPECT_FALSE(features::is_of_another_scale(found)) << houses;
  }
}

TEST(RivalPoses, AStreetOfOtherHousesHasNoneThatIsAsGood) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const Seen source(scan_of(street(seed), 5.0, 0.0, 1)), target(scan_of(street(seed), 0.0, 0.0, 2));
    const PoseEvidence found = evidence(source, target, between_scans(5.0, 0.0, 0.0, 0.0));
    EXPECT_FALSE(features::has_equal_rival(found)) << seed << " " << found.rival->share_of_score;
    EXPECT_TRUE(features::is_borne_out(found, kByCorrespondences)) << seed;
  }
}

TEST(RivalPoses, OneAtWhichFewerSurfacesAgreeNeedsFourFifthsOfTheScore) {
  PoseEvidence found{.agreement = 0.5, .samples = 640};
  found.rival = features::RivalPose{.share_of_score = 0.79, .agreement = 0.4};
  EXPECT_FALSE(features::has_equal_rival(found));
  found.rival->share_of_score = 0.8;
  EXPECT_TRUE(features::has_equal_rival(found));
  // With them, one that is seen through as right poses are not is none, unless the pose is no better.
  found.displaced_agreement = 0.2;
  found.displaced_seen_through = 0.1;
  found.rival->seen_through = 0.02;
  EXPECT_FALSE(features::has_equal_rival(found));
  found.seen_through = 0.02;
  EXPECT_TRUE(features::has_equal_rival(found));
  // One that nothing speaks against is as good with less.
  found.rival->share_of_score = 0.6;
  found.rival->seen_through = 0.004;
  EXPECT_TRUE(features::has_equal_rival(found));
  found.rival->share_of_score = 0.49;
  EXPECT_FALSE(features::has_equal_rival(found));
}

// Of surfaces that displaced poses share, which hardly count, as of a screw that is turned end for end.
TEST(RivalPoses, OneThatMoreSurfacesAgreeAtNeedsHalfOfTheScore) {
  PoseEvidence found{.agreement = 0.5, .samples = 640};
  found.rival = features::RivalPose{.share_of_score = 0.5, .share_of_agreement = 1.0, .agreement = 0.5};
  EXPECT_TRUE(features::has_equal_rival(found));
  found.rival->share_of_score = 0.49;
  EXPECT_FALSE(features::has_equal_rival(found));
  found.rival->share_of_score = 0.79;
  found.rival->share_of_agreement = 0.99;
  EXPECT_FALSE(features::has_equal_rival(found));
  found.rival->share_of_agreement = 1.2;
  found.displaced_agreement = 0.2;
  found.displaced_seen_through = 0.1;
  found.rival->seen_through = 0.1;
  EXPECT_FALSE(features::has_equal_rival(found));
}

TEST(RivalPoses, MakeASuccessAmbiguous) {
  const Points points = scan_of(like_houses(kPeriod), 3.0, 0.0, 1);
  const Seen source(points), target(scan_of(like_houses(kPeriod), 0.0, 0.0, 2));
  const RigidTransform right = between_scans(3.0, 0.0, 0.0, 0.0);
  std::vector<std::array<double, 3>> from, to;
  for (std::size_t k = 0; k < points.size(); k += 300) {
    from.push_back(points[k]);
    to.push_back(moved(right, {points[k]})[0]);
  }
  const Correspondences rows(PointSpan<double>::interleaved(from.front().data(), from.size()),
                             PointSpan<double>::interleaved(to.front().data(), to.size()));
  Registration result;
  result.status = Status::success;
  result.T_target_source = right;
  result.log10_false_poses = kByCorrespondences;
  result.noise_bound = 0.3;
  const PoseVerifier verifier({source.scan, source.surfaces}, {target.scan, target.surfaces}, kVoxel);
  const features::CloudVerdict verdict = features::decide(verifier, rows, result);
  EXPECT_EQ(verdict.of_correspondences, Status::success);
  EXPECT_EQ(result.status, Status::ambiguous);
  EXPECT_EQ(result.T_target_source.matrix(), right.matrix());
  ASSERT_TRUE(result.runner_up);
  EXPECT_LT(from_a_whole_house(result.runner_up->T_target_source, right), 0.5);
  EXPECT_LT(result.runner_up->support, rows.size() / 2);
  ASSERT_TRUE(verdict.runner_up);
  EXPECT_GT(verdict.runner_up->agreement, 0.5 * verdict.pose->agreement);
}

// From the front end on: the correspondences alone call each of these a success, and none of the poses is right.
TEST(RivalPoses, RowsOfLikeHousesAreNoSuccess) {
  for (std::uint32_t seed = 4; seed <= 6; ++seed) {
    const double ahead = 1.5 * seed;
    const auto found =
        features::register_clouds(cloud_of(scan_of(like_houses(13.0), ahead, 0.4, seed, 48, 1000)),
                                  cloud_of(scan_of(like_houses(13.0), 0.0, 0.0, 9, 48, 1000)), {.seed = seed});
    EXPECT_EQ(found.verdict->of_correspondences, Status::success) << seed;
    EXPECT_EQ(found.registration.status, Status::ambiguous) << seed;
    EXPECT_TRUE(features::has_equal_rival(*found.verdict->pose)) << seed;
  }
}

// A tin: every turn about its axis is as good as another. The correspondences alone call some of these a success.
TEST(RivalPoses, ATinIsNoSuccess) {
  const auto tin = [](std::uint32_t seed) {
    std::mt19937 random(seed);
    Points points;
    while (points.size() < 6000) {
      const double angle = std::numbers::pi * uniform(random);
      const bool cap = random() % 5 == 0;
      const double radius = cap ? std::sqrt(0.5 + 0.5 * uniform(random)) : 1.0;
      const double height = cap ? (random() % 2 == 0 ? -2.0 : 2.0) : 2.0 * uniform(random);
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), height});
      for (double& x : points.back()) x += 0.004 * uniform(random);
    }
    return points;
  };
  int called_a_success = 0;
  for (const std::uint32_t seed : {6U, 9U, 10U, 13U, 17U, 22U}) {
    const auto found =
        features::register_clouds(cloud_of(moved(some_pose(), tin(seed))), cloud_of(tin(seed + 10)), {.seed = seed});
    called_a_success += found.verdict->of_correspondences == Status::success ? 1 : 0;
    EXPECT_NE(found.registration.status, Status::success) << seed;
  }
  EXPECT_GE(called_a_success, 1);
}

TEST(ScaledFit, FindsTheScaleOfAnEnlargedCloud) {
  for (const double scale : {1.0, 0.95, 1.05}) {
    const Seen source(scan_of(street(2), 1.0, 0.0, 1));
    Points enlarged = scan_of(street(2), 0.0, 0.0, 2);
    for (auto& p : enlarged) {
      for (double& x : p) x *= scale;
    }
    const PoseEvidence found = evidence(source, Seen(enlarged), between_scans(1.0, 0.0, 0.0, 0.0));
    EXPECT_EQ(features::is_of_another_scale(found), scale != 1.0) << scale << " " << found.scaled.gain;
    EXPECT_NEAR(found.scaled.scale, scale, 0.003);
    EXPECT_EQ(features::is_borne_out(found, kByCorrespondences), scale == 1.0) << scale;
  }
}

// What sensors are off by is told, and refuses nothing.
TEST(ScaledFit, ToleratesAHundredth) {
  const PoseEvidence found{.agreement = 0.5, .samples = 640, .scaled = {.scale = 1.01, .gain = 1.4}};
  EXPECT_TRUE(features::agrees_better_scaled(found));
  EXPECT_FALSE(features::is_of_another_scale(found));
}

/// On a cone about an axis beside the origin: every turn about it is as good.
Points cone(std::uint32_t seed) {
  std::mt19937 random(seed);
  Points points;
  while (points.size() < 20000) {
    const double angle = std::numbers::pi * uniform(random);
    const double height = 6.0 + 4.0 * uniform(random);
    points.push_back({0.3 * height * std::cos(angle) + 3.0, 0.3 * height * std::sin(angle), height});
  }
  return points;
}

// Where the axis is comes from all points: of the 320 samples alone two of the cones would have no rival.
TEST(RivalPoses, ConesHaveOneForEveryTurn) {
  int equal = 0;
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    const Seen source(cone(seed)), target(cone(seed + 100));
    const PoseEvidence found = PoseVerifier({source.scan, source.surfaces, std::nullopt},
                                            {target.scan, target.surfaces, std::nullopt}, kVoxel, seed)
                                   .evidence(RigidTransform::Identity());
    equal += features::has_equal_rival(found) ? 1 : 0;
  }
  EXPECT_EQ(equal, 20);
}

/// On three balls of other sizes.
Points three_balls(const Eigen::Vector3d& shift, std::uint32_t seed) {
  std::mt19937 random(seed);
  const Eigen::Vector3d centres[] = {{0.0, 0.0, 0.0}, {2.5, 0.5, 0.0}, {0.5, 2.0, 1.5}};
  const double radii[] = {1.5, 1.0, 0.7};
  Points points;
  while (points.size() < 6000) {
    const Eigen::Vector3d ray{{uniform(random), uniform(random), uniform(random)}};  // in this order
    if (ray.norm() > 1.0) continue;
    const std::size_t ball = random() % 3;
    const Eigen::Vector3d place = shift + centres[ball] + radii[ball] * ray.normalized();
    points.push_back({place.x(), place.y(), place.z()});
  }
  return points;
}

// No surface faces across the shift between the two, which is longer than they are spread.
TEST(RivalPoses, TwoLikeObjectsOfWhichOneScanHasOneAreTold) {
  const Seen source(three_balls({0.0, 0.0, 0.0}, 1));
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(12.0, 7.0, 5.0), Eigen::Vector3d(-3.0, 20.0, -9.0)}) {
    Points both = three_balls({0.0, 0.0, 0.0}, 2);
    const Points other = three_balls(shift, 3);
    both.insert(both.end(), other.begin(), other.end());
    const PoseEvidence found = evidence(source, Seen(both), RigidTransform::Identity());
    ASSERT_TRUE(found.rival);
    EXPECT_TRUE(features::has_equal_rival(found)) << found.rival->share_of_score;
    EXPECT_LT((found.rival->T_target_source.translation() - shift).norm(), 0.1);
    EXPECT_LT((found.rival->T_target_source.linear() - Eigen::Matrix3d::Identity()).norm(), 0.1);
  }
}

// Some points with normals, far from one another.
TEST(RivalPoses, TargetsOfFewSurfacesAreHeldAgainstPoses) {
  const Seen source(scan_of(street(1), 0.0, 0.0, 1));
  for (const std::size_t count : {1u, 2u, 3u, 6u, 12u}) {
    Points points;
    for (std::size_t k = 0; k < count; ++k) points.push_back({5.0 * static_cast<double>(k), 1.0, 0.5});
    Cloud cloud = cloud_of(points);
    const std::vector<float> flat(count, 0.0F), up(count, 1.0F);
    cloud.set_normals({flat.data(), flat.data(), up.data()});
    const features::CellGrid surfaces(cloud, 3.0 * kVoxel);
    const PoseEvidence found =
        PoseVerifier({source.scan, source.surfaces}, {cloud, surfaces}, kVoxel).evidence(RigidTransform::Identity());
    EXPECT_TRUE(std::isfinite(found.log10_chance) && std::isfinite(found.scaled.scale)) << count;
  }
}

}  // namespace
}  // namespace consimd::test
