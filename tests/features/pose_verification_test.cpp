#include <consimd/features/cloud_verdict.hpp>
#include <consimd/features/pose_verification.hpp>
#include <consimd/features/register_clouds.hpp>

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <optional>
#include <vector>

#include "scene.hpp"
#include "seen.hpp"
#include "street.hpp"

namespace consimd::test {
namespace {

using features::PoseEvidence;
using features::PoseVerifier;

// As the correspondences of poses that are just a success give it.
constexpr double kByCorrespondences = -4.5;

TEST(PoseVerification, BearsTheRightPoseOut) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const Street scene = street(seed);
    const Seen source(scan_of(scene, 8.0, 0.4, 1)), target(scan_of(scene, 0.0, 0.1, 2));
    const PoseEvidence found = evidence(source, target, between_scans(8.0, 0.4, 0.0, 0.1));
    EXPECT_TRUE(features::is_borne_out(found, kByCorrespondences)) << found.log10_chance << " " << found.seen_through;
    EXPECT_GT(found.agreement, 0.3);
    EXPECT_LT(found.seen_through, 0.02);
    EXPECT_GT(found.samples, 600u);
  }
}

// Both streets have ground and houses at about the same place: what such poses agree in is structure. Poses that are
// the same up to a turn by half a circle or a shift along the street. None of 64 may pass.
TEST(PoseVerification, RefusesPosesBetweenDifferentStreets) {
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const Seen source(scan_of(street(seed), 0.0, 0.0, 1)), target(scan_of(street(seed + 100), 0.0, 0.0, 2));
    const PoseVerifier verifier({source.scan, source.surfaces}, {target.scan, target.surfaces}, kVoxel);
    for (const double yaw : {0.0, 3.141592653589793}) {
      for (const double shift : {-6.0, -1.5, 0.0, 4.0}) {
        const PoseEvidence found = verifier.evidence(between_scans(shift, yaw, 0.0, 0.0));
        EXPECT_FALSE(features::is_borne_out(found, kByCorrespondences))
            << seed << " " << yaw << " " << shift << ": " << found.log10_chance << " " << found.seen_through;
      }
    }
  }
}

TEST(PoseVerification, AWrongPoseIsSeenThrough) {
  const Street scene = street(3);
  const Seen source(scan_of(scene, 12.0, 0.0, 1)), target(scan_of(scene, 0.0, 0.0, 2));
  const PoseEvidence right = evidence(source, target, between_scans(12.0, 0.0, 0.0, 0.0));
  const PoseEvidence wrong = evidence(source, target, between_scans(12.0, 0.3, 0.0, 0.0));
  EXPECT_LT(right.seen_through, 0.02);
  EXPECT_GT(wrong.seen_through, 0.05);
}

// Along two bare walls any shift agrees as well.
TEST(PoseVerification, AShiftAlongABareStreetIsNoEvidence) {
  const Street scene = street(1, true);
  const Seen source(scan_of(scene, 3.0, 0.0, 1)), target(scan_of(scene, 0.0, 0.0, 2));
  const PoseEvidence found = evidence(source, target, between_scans(3.0, 0.0, 0.0, 0.0));
  EXPECT_GT(found.agreement, 0.6);
  EXPECT_GT(found.log10_chance, -2.5);
}

TEST(PoseVerification, WithoutViewpointsNothingIsSeenThrough) {
  const Street scene = street(2);
  const Seen source(scan_of(scene, 5.0, 0.0, 1)), target(scan_of(scene, 0.0, 0.0, 2));
  const RigidTransform wrong = between_scans(5.0, 0.4, 0.0, 0.0);
  for (const std::optional<std::array<double, 3>> viewpoint :
       {std::optional<std::array<double, 3>>(), std::optional(std::array<double, 3>{300.0, 5.0, 1.0})}) {
    const PoseVerifier verifier({source.scan, source.surfaces, viewpoint}, {target.scan, target.surfaces, viewpoint},
                                kVoxel);
    EXPECT_EQ(verifier.evidence(wrong).seen_through, 0.0);
    EXPECT_TRUE(features::is_borne_out(verifier.evidence(between_scans(5.0, 0.0, 0.0, 0.0)), kByCorrespondences));
  }
}

TEST(PoseVerification, HasTheSameBitsForAnyThreadsAndDependsOnTheSeedAlone) {
  const Street scene = street(5);
  const Seen source(scan_of(scene, 6.0, 0.0, 1)), target(scan_of(scene, 0.0, 0.0, 2));
  const RigidTransform pose = between_scans(6.0, 0.0, 0.0, 0.0);
  std::vector<PoseEvidence> found;
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    found.push_back(arena.execute([&] { return evidence(source, target, pose); }));
    EXPECT_EQ(found[0].log10_chance, found.back().log10_chance);
    EXPECT_EQ(found[0].scaled.scale, found.back().scaled.scale);
    EXPECT_EQ(found[0].scaled.gain, found.back().scaled.gain);
    ASSERT_TRUE(found[0].rival && found.back().rival);
    EXPECT_EQ(found[0].rival->T_target_source.matrix(), found.back().rival->T_target_source.matrix());
    EXPECT_EQ(found[0].rival->share_of_score, found.back().rival->share_of_score);
  }
  EXPECT_NE(evidence(source, target, pose, 2).log10_chance, evidence(source, target, pose).log10_chance);
}

TEST(PoseVerification, MapCoordinatesChangeLittle) {
  const Street scene = street(6);
  const Points source = scan_of(scene, 6.0, 0.0, 1);
  const Points target = scan_of(scene, 0.0, 0.0, 2);
  const RigidTransform pose = between_scans(6.0, 0.0, 0.0, 0.0);
  const PoseEvidence here = evidence(Seen(source), Seen(target), pose);
  Points far = target;
  for (auto& p : far) p[1] += 5e6;
  const Seen near(source), away(far);
  RigidTransform there = pose;
  there.translation().y() += 5e6;
  const PoseEvidence found =
      PoseVerifier({near.scan, near.surfaces}, {away.scan, away.surfaces, {{0.0, 5e6, 0.0}}}, kVoxel).evidence(there);
  EXPECT_NEAR(found.agreement, here.agreement, 0.05);
  EXPECT_NEAR(found.seen_through, here.seen_through, 0.01);
}

TEST(PoseVerification, CloudsWithoutSurfacesDecideNothing) {
  const Seen street_scan(scan_of(street(1), 0.0, 0.0, 1));
  for (const std::size_t count : {0u, 1u, 2u}) {
    const Seen few(Points(count, {1.0, 2.0, 3.0}));
    const PoseVerifier verifier({few.scan, few.surfaces}, {street_scan.scan, street_scan.surfaces}, kVoxel);
    const PoseEvidence found = verifier.evidence(RigidTransform::Identity());
    EXPECT_EQ(found.samples, 0u);
    EXPECT_EQ(found.log10_chance, 0.0);
    Registration registration;
    registration.status = Status::success;
    static_cast<void>(features::decide(verifier, Correspondences(), registration));
    EXPECT_EQ(registration.status, Status::success);
  }
}

TEST(PoseVerification, RefusesBadInput) {
  const Seen seen(scan_of(street(1), 0.0, 0.0, 1));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double voxel : {0.0, -1.0, 1e-300, 1e-5, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(PoseVerifier({seen.scan, seen.surfaces}, {seen.scan, seen.surfaces}, voxel), std::invalid_argument);
  }
  EXPECT_THROW(PoseVerifier({seen.scan, seen.surfaces, {{nan, 0.0, 0.0}}}, {seen.scan, seen.surfaces}, kVoxel),
               std::invalid_argument);
  RigidTransform pose = RigidTransform::Identity();
  pose.translation().x() = nan;
  EXPECT_THROW(static_cast<void>(evidence(seen, seen, pose)), std::invalid_argument);
}

/// Rows that the true pose takes to one another, and some that nothing does; or `few` of the former alone.
Correspondences rows_of(const Points& source, const RigidTransform& pose, std::size_t few = 0) {
  std::vector<std::array<double, 3>> from, to;
  std::mt19937 random(3);
  const auto is_right = [few](std::size_t row) { return few == 0 ? row % 3 != 0 : row % 30 == 1 && row / 30 < few; };
  for (std::size_t k = 0; k < source.size(); k += 200) {
    from.push_back(source[k]);
    Eigen::Vector3d q = pose * Eigen::Map<const Eigen::Vector3d>(source[k].data());
    for (int c = 0; c < 3; ++c) q[c] += (is_right(from.size()) ? 0.05 : 20.0) * uniform(random);
    to.push_back({q.x(), q.y(), q.z()});
  }
  return Correspondences(PointSpan<double>::interleaved(from.front().data(), from.size()),
                         PointSpan<double>::interleaved(to.front().data(), to.size()));
}

class CloudVerdict : public testing::Test {
 protected:
  const Street scene_ = street(6);
  const Points points_ = scan_of(scene_, 4.0, 0.0, 1);
  const Seen source_{points_};
  const Seen target_{scan_of(scene_, 0.0, 0.0, 2)};
  const PoseVerifier verifier_{{source_.scan, source_.surfaces}, {target_.scan, target_.surfaces}, kVoxel};
  const Seen elsewhere_{scan_of(street(106), 0.0, 0.0, 2)};
  const PoseVerifier between_places_{{source_.scan, source_.surfaces}, {elsewhere_.scan, elsewhere_.surfaces}, kVoxel};
  const RigidTransform right_ = between_scans(4.0, 0.0, 0.0, 0.0);
  const RigidTransform wrong_ = between_scans(-9.0, 0.2, 0.0, 0.0);
  const Correspondences correspondences_ = rows_of(points_, right_);

  Registration with(Status status, const RigidTransform& pose, double log10_false_poses = -6.0) const {
    Registration result;
    result.status = status;
    result.T_target_source = pose;
    result.inliers = {1, 2, 3, 4};
    result.covariance = PoseCovariance::Identity();
    result.log10_false_poses = log10_false_poses;
    result.noise_bound = 0.2;
    return result;
  }

  void expect_the_right_pose(const Registration& result) const {
    EXPECT_EQ(result.status, Status::success);
    EXPECT_LT((result.T_target_source.matrix() - right_.matrix()).norm(), 0.1);
    EXPECT_TRUE(std::ranges::is_sorted(result.inliers));
    EXPECT_FALSE(result.refused);
    EXPECT_FALSE(result.runner_up);
  }
};

TEST_F(CloudVerdict, ARightPoseStaysAsItIs) {
  Registration result = with(Status::success, right_);
  const features::CloudVerdict verdict = features::decide(verifier_, correspondences_, result);
  EXPECT_EQ(verdict.of_correspondences, Status::success);
  EXPECT_EQ(result.T_target_source.matrix(), right_.matrix());
  EXPECT_EQ(result.inliers.size(), 4u);
  ASSERT_EQ(result.stages.size(), 1u);
  EXPECT_EQ(result.stages[0].name, "verification");
  EXPECT_EQ(result.stages[0].input, verdict.pose->samples);
  expect_the_right_pose(result);
}

TEST_F(CloudVerdict, APoseBetweenDifferentPlacesIsRefused) {
  for (const Status status : {Status::success, Status::ambiguous, Status::budget_exhausted}) {
    Registration result = with(status, wrong_, -30.0);
    if (status == Status::ambiguous) result.runner_up = RunnerUp{between_scans(-20.0, 1.0, 0.0, 0.0), 4, -5.0};
    const features::CloudVerdict verdict = features::decide(between_places_, correspondences_, result);
    EXPECT_FALSE(verdict.found_by_clouds);
    EXPECT_EQ(result.status, Status::no_consensus);
    EXPECT_TRUE(result.inliers.empty());
    EXPECT_EQ(result.T_target_source.matrix(), RigidTransform::Identity().matrix());
    EXPECT_TRUE(result.covariance.isZero(0.0));
    ASSERT_TRUE(result.refused);
    EXPECT_EQ(result.refused->T_target_source.matrix(), wrong_.matrix());
    EXPECT_FALSE(result.runner_up);
  }
}

// 13 m along the street, with the same ground and houses in a line: the clouds have a better pose there.
TEST_F(CloudVerdict, AWrongPoseLeadsToTheRightOne) {
  for (const Status status : {Status::success, Status::no_consensus}) {
    Registration result = with(status, wrong_);
    if (status == Status::no_consensus) result.refused = RunnerUp{wrong_, 4, -1.0};
    const features::CloudVerdict verdict = features::decide(verifier_, correspondences_, result);
    EXPECT_TRUE(verdict.found_by_clouds);
    expect_the_right_pose(result);
    EXPECT_LT((result.T_target_source.matrix() - right_.matrix()).norm(), 0.05);
    EXPECT_GT(result.inliers.size(), correspondences_.size() / 2);
    EXPECT_LT(result.log10_false_poses, -10.0);
    EXPECT_LT(verdict.log10_of_both, verdict.pose->log10_chance);
    EXPECT_LT(verdict.pose->rival->share_of_score, 0.8);
    EXPECT_GT(verdict.runner_up->rival->share_of_score, 1.0);  // of the pose that was followed from
  }
}

// No row supports it: whatever the clouds say, that is no registration of these correspondences.
TEST_F(CloudVerdict, APoseThatNoRowSupportsIsNoSuccess) {
  Registration result = with(Status::no_consensus, wrong_);
  result.refused = RunnerUp{wrong_, 4, -1.0};
  Points away = points_;
  for (auto& p : away) p[2] += 30.0;
  const features::CloudVerdict verdict = features::decide(verifier_, rows_of(away, right_.inverse()), result);
  EXPECT_FALSE(verdict.found_by_clouds);
  EXPECT_EQ(result.status, Status::no_consensus);
}

// Two attempts that lead to one pose need less of each: what one led to is told, and believed where another does.
TEST_F(CloudVerdict, WhatTwoAttemptsLeadToNeedsLess) {
  EXPECT_TRUE(verifier_.are_alike(right_, between_scans(4.4, 0.0, 0.0, 0.0)));
  EXPECT_FALSE(verifier_.are_alike(right_, between_scans(7.0, 0.0, 0.0, 0.0)));
  EXPECT_FALSE(verifier_.are_alike(right_, between_scans(4.0, 0.3, 0.0, 0.0)));
  std::size_t told = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const Street scene = street(seed);
    const double ahead = 18.0;
    const Points points = scan_of(scene, ahead, 0.2, 1);
    const Seen source(points), target(scan_of(scene, 0.0, 0.0, 2));
    const RigidTransform right = between_scans(ahead, 0.2, 0.0, 0.0);
    const PoseVerifier verifier({source.scan, source.surfaces}, {target.scan, target.surfaces}, kVoxel);
    const auto decided = [&](const std::optional<RigidTransform>& led_to_before) {
      Registration result;
      result.noise_bound = 0.2;
      result.refused = RunnerUp{right, 4, 2.0};
      const features::CloudVerdict verdict =
          features::decide(verifier, rows_of(points, right, 3), result, led_to_before);
      return std::pair(verdict, result);
    };
    const auto [verdict, result] = decided(std::nullopt);
    if (!verdict.led_to) continue;
    ++told;
    EXPECT_FALSE(result.has_pose());
    EXPECT_LT((verdict.led_to->matrix() - right.matrix()).norm(), 0.3);
    EXPECT_FALSE(decided(between_scans(9.0, 0.2, 0.0, 0.0)).second.has_pose());
    const auto [again, believed] = decided(verdict.led_to);
    EXPECT_TRUE(again.found_by_clouds);
    EXPECT_EQ(believed.T_target_source.matrix(), verdict.led_to->matrix());
  }
  EXPECT_GT(told, 0u);
}

TEST_F(CloudVerdict, DecidesBetweenAPoseAndItsRival) {
  for (const bool first : {true, false}) {
    Registration result = with(Status::ambiguous, first ? right_ : wrong_);
    result.runner_up = RunnerUp{first ? wrong_ : right_, 4, -6.0};
    features::decide(verifier_, correspondences_, result);
    expect_the_right_pose(result);
    EXPECT_GE(result.inliers.size(), first ? 4u : correspondences_.size() / 2);
  }
}

TEST_F(CloudVerdict, TakesARightPoseThatHadTooFewCorrespondences) {
  {
    Registration result;
    result.noise_bound = 0.2;
    result.refused = RunnerUp{right_, 4, -3.5};
    features::decide(verifier_, correspondences_, result);
    expect_the_right_pose(result);
    EXPECT_GT(result.inliers.size(), correspondences_.size() / 2);
    EXPECT_FALSE(result.covariance.isZero(0.0));
  }
  Registration result;
  result.noise_bound = 0.2;
  result.refused = RunnerUp{wrong_, 4, -2.0};
  features::decide(between_places_, correspondences_, result);
  EXPECT_EQ(result.status, Status::no_consensus);
  EXPECT_TRUE(result.refused);
}

// Along their rings points are close to one another, so that voxels of that side show no surfaces.
TEST(RegisterVerifiedClouds, ScansOfFewRingsAreFoundWithLargerVoxels) {
  int found = 0;
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const Cloud source = cloud_of(scan_of(street(seed), 4.0, 0.3, 1, 12, 1440));
    const Cloud target = cloud_of(scan_of(street(seed), 0.0, 0.0, 2, 12, 1440));
    const auto result = features::register_clouds(source, target, {.seed = seed});
    if (result.registration.status != Status::success) continue;
    EXPECT_LT(
        (result.registration.T_target_source.translation() - between_scans(4.0, 0.3, 0.0, 0.0).translation()).norm(),
        result.attempts > 1 ? 0.1 : 1.0);
    // A pose of coarser voxels is refined on them.
    if (result.attempts > 1) {
      EXPECT_EQ(result.registration.stages.back().name, "refine") << seed;
    }
    ++found;
  }
  EXPECT_GE(found, 4);  // all five, by the second or third attempt
}

// Whichever attempt it is that a stop ends, there is no further one, and the result says so.
TEST(RegisterVerifiedClouds, AStopEndsAllAttempts) {
  const Cloud source = cloud_of(scan_of(street(1), 4.0, 0.3, 1));
  const Cloud target = cloud_of(scan_of(street(51), 0.0, 0.0, 2));
  features::CloudRegistrationOptions options;
  options.matching.voxel = kVoxel;
  options.matching.keypoints = 2000;
  const std::atomic<bool> requested = true;
  options.stop.requested = &requested;
  const auto stopped = register_clouds(source, target, options);
  EXPECT_TRUE(stopped.registration.stopped);
  EXPECT_EQ(stopped.attempts, 1u);
  options.stop.requested = nullptr;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(register_clouds(source, target, options).attempts, 4u);
  const auto whole = std::chrono::steady_clock::now() - start;
  // Deadlines grow until one is not met, by a fifth each: the first attempt takes less than half of the time.
  bool later_ones_are_stopped = false;
  bool all_are_through = false;
  for (auto wait = whole / 50; !all_are_through && wait < 50 * whole; wait = 6 * wait / 5) {
    options.stop.deadline = std::chrono::steady_clock::now() + wait;
    const auto result = register_clouds(source, target, options);
    EXPECT_FALSE(result.registration.has_pose());
    all_are_through = !result.registration.stopped;
    EXPECT_TRUE(result.registration.stopped || result.attempts == 4);
    later_ones_are_stopped = later_ones_are_stopped || (result.registration.stopped && result.attempts > 1);
  }
  EXPECT_TRUE(later_ones_are_stopped);
}

// Problems without a pose: scans of different streets, from the front end on; and the same ones with it.
TEST(RegisterVerifiedClouds, DifferentStreetsAreRefusedAndTheSameOnesFound) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    features::CloudRegistrationOptions options;
    options.matching.voxel = kVoxel;
    options.matching.keypoints = 2000;
    options.seed = options.matching.seed = seed;
    const Cloud source = cloud_of(scan_of(street(seed), 4.0, 0.3, 1));
    const auto other = register_clouds(source, cloud_of(scan_of(street(seed + 50), 0.0, 0.0, 2)), options);
    EXPECT_FALSE(other.registration.has_pose());
    EXPECT_EQ(other.attempts, 4u);
    EXPECT_DOUBLE_EQ(other.matches.voxel, kVoxel);
    const auto same = register_clouds(source, cloud_of(scan_of(street(seed), 0.0, 0.0, 2)), options);
    ASSERT_EQ(same.registration.status, Status::success);
    EXPECT_LT(
        (same.registration.T_target_source.translation() - between_scans(4.0, 0.3, 0.0, 0.0).translation()).norm(),
        0.3);
    ASSERT_TRUE(same.verdict && same.verdict->pose);
    EXPECT_LT(same.verdict->pose->log10_chance, -2.5);
  }
}

}  // namespace
}  // namespace consimd::test
