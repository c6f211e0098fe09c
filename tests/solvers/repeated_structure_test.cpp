// What the verdict is told of structure that repeats: rows whose sources look alike, and motions that differ by a
// shift.
#include <consimd/synth/hard_problems.hpp>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "problems.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/lookalikes.hpp"
#include "verdict/shifted_motion.hpp"

namespace consimd::test {
namespace {

constexpr double kBound = 0.2;

// Matches of corners of windows with the same corners of any windows: `columns` by columns / 2 of them.
Problem facade(std::size_t rows, double outlier_ratio, std::size_t columns) {
  return synth::hard_problem({.correspondences = rows,
                              .outlier_ratio = outlier_ratio,
                              .sigma = 0.02,
                              .half_extent = 25.0,
                              .scene = synth::Scene::facade,
                              .parts = columns,
                              .outliers = synth::OutlierModel::alike});
}

detail::PairingHits lookalike_support(const Problem& problem, const RigidTransform& pose) {
  const Correspondences correspondences = problem.correspondences();
  const CorrespondenceView view = correspondences.view();
  const WorkingPose working = detail::scored(correspondences, pose, kBound).pose;
  const detail::Lookalikes lookalikes(view, kBound, detail::kNearMisses * kBound);
  return lookalikes.support(working, kBound, detail::MatchedPoints(view, working, kBound));
}

TEST(LookalikeRows, GiveEveryShiftItsShareOfTheWindows) {
  // A corner's mates are at any of the 32 windows but the one or two of a hundred rows that its source was matched
  // with.
  const Problem problem = facade(2000, 1.0, 8);
  const detail::PairingHits hits = lookalike_support(problem, problem.decoy_T_target_source);
  ASSERT_GT(hits.trials, 10000.0);
  // Each source was matched with about 12 of the 32 windows, which are no test; one in 32 of the others is right.
  EXPECT_GT(hits.hits[0] / hits.trials, 0.5 / 32);
  EXPECT_LT(hits.hits[0] / hits.trials, 1.5 / 32);
  EXPECT_GE(hits.hits[0], hits.hits[3]);
}

TEST(LookalikeRows, AreNoneWherePointsAreInOneRowEach) {
  const Problem problem = synth::hard_problem({.correspondences = 2000, .outlier_ratio = 0.9, .sigma = 0.02});
  const detail::PairingHits hits = lookalike_support(problem, problem.T_target_source);
  EXPECT_EQ(hits.trials, 0.0);
  EXPECT_EQ(hits.hits[0], 0.0);
}

TEST(ShiftedMotion, IsAnotherWindow) {
  const Problem problem = facade(3000, 1.0, 8);
  const Correspondences correspondences = problem.correspondences();
  detail::BestPoses poses(correspondences, kBound);
  poses.promote(detail::scored(correspondences, problem.decoy_T_target_source, kBound));
  const detail::RepeatedMotions shifts = detail::shifted_motions(correspondences, poses, kBound);
  // A shift by one column joins 7/8 of the windows, each with one in 32 of its matches: 82 of them.
  EXPECT_GT(shifts.best.support.count, 40U);
  EXPECT_LT(shifts.best.support.count, 200U);
  EXPECT_FALSE(poses.same_motion_as_best(shifts.best.pose));
}

TEST(ShiftedMotion, HasNoSupportWithoutThreeRowsThatAgree) {
  const Problem problem = synth::hard_problem({.correspondences = 100, .outlier_ratio = 0.9, .sigma = 0.02});
  const Correspondences correspondences = problem.correspondences();
  detail::BestPoses poses(correspondences, kBound);
  poses.promote(detail::scored(correspondences, problem.T_target_source, kBound));
  const detail::RepeatedMotions shifts = detail::shifted_motions(correspondences, poses, kBound);
  EXPECT_LT(shifts.best.support.count, 3U);
  EXPECT_TRUE(shifts.independent.empty());
}

TEST(RepeatedMotions, AreMoreThanChanceWhereWindowsAreInTwoRowsEach) {
  // 512 corners and 1000 rows: no place of the target has enough rows for lookalikes to tell.
  const Problem problem = facade(1000, 1.0, 16);
  const Correspondences correspondences = problem.correspondences();
  detail::BestPoses poses(correspondences, kBound);
  poses.promote(detail::scored(correspondences, problem.decoy_T_target_source, kBound));
  const detail::RepeatedMotions shifts = detail::shifted_motions(correspondences, poses, kBound);
  ASSERT_GE(shifts.independent.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(shifts.independent, std::ranges::greater{}));
  // A source is paired at random with one of 128 windows and four corners.
  EXPECT_LT(detail::log_chance_of(shifts, 1000.0, 1.0 / 512), std::log(1e-3));
}

TEST(ChanceOfShifts, IsThatOfCounts) {
  // Ten of 1000 rows that a shift takes to others with a chance of one in a thousand: each row tells such a shift with
  // a chance of 10^-6, and ten tell the same one.
  const double ten = detail::log_chance_of({{}, {10.0}}, 1000.0, 1e-3);
  EXPECT_NEAR(ten / std::log(10.0), std::log10(1000.0 / 10.0 * 1.1e-6), 0.3);
  EXPECT_LT(detail::log_chance_of({{}, {10.0, 10.0}}, 1000.0, 1e-3), 1.5 * ten);
  EXPECT_EQ(detail::log_chance_of({{}, {1.0, 1.0}}, 1000.0, 1e-3), 0.0);
  EXPECT_EQ(detail::log_chance_of({}, 1000.0, 1e-3), 0.0);
  // The more motions were looked at, the less it tells.
  const double of_few = detail::log_chance_of({{}, {10.0}, 100.0}, 1000.0, 1e-3);
  EXPECT_LT(of_few, -10.0);
  EXPECT_NEAR(detail::log_chance_of({{}, {10.0}, 1000.0}, 1000.0, 1e-3), of_few + std::log(10.0), 0.1);
}

TEST(FitGain, IsThatOfLeastSquares) {
  // Residuals of n rows around the pose fitted to them, and of as many rows that it was not fitted to.
  for (const std::size_t count : {5UL, 8UL, 20UL}) {
    double fitted = 0.0;
    double others = 0.0;
    for (std::uint64_t trial = 0; trial < 400; ++trial) {
      const Problem problem =
          synth::hard_problem({.correspondences = 2 * count, .outlier_ratio = 0.0, .sigma = 0.01, .trial = trial});
      Eigen::Matrix3Xd source(3, static_cast<Eigen::Index>(count));
      Eigen::Matrix3Xd target = source;
      for (std::size_t k = 0; k < count; ++k) {
        source.col(static_cast<Eigen::Index>(k)) = source_point(problem, k);
        target.col(static_cast<Eigen::Index>(k)) = target_point(problem, k);
      }
      const Eigen::Matrix4d pose = Eigen::umeyama(source, target, false);
      const auto square = [&](std::size_t k) {
        const Eigen::Vector3d moved =
            pose.topLeftCorner<3, 3>() * source_point(problem, k) + pose.topRightCorner<3, 1>();
        return (moved - target_point(problem, k)).squaredNorm();
      };
      for (std::size_t k = 0; k < count; ++k) {
        fitted += square(k);
        others += square(count + k);
      }
    }
    detail::Supports supports;
    supports.front().count = static_cast<double>(count);
    // Rows outside of the fitted ones' hull, of which there are more the fewer these are, are further off than the
    // mean.
    EXPECT_GT(std::sqrt(others / fitted), 0.95 * detail::fit_gain(supports)) << count;
    EXPECT_LT(std::sqrt(others / fitted), 1.5 * detail::fit_gain(supports)) << count;
  }
}

}  // namespace
}  // namespace consimd::test
