// What rows that a pose does not explain keep of their sources, and what that makes of chance.
#include <consimd/solvers/significance.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "problems.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/kept_agreement.hpp"
#include "verdict/kept_viewpoint.hpp"

namespace consimd::test {
namespace {

struct AtPose {
  detail::Chances at_random;
  std::vector<detail::KeptChances> kept;
};

AtPose chances_at(const Correspondences& correspondences, const RigidTransform& pose, double sigma) {
  const CorrespondenceView view = correspondences.view();
  const double bound = synth::noise_study_bound(sigma);
  const WorkingPose working = detail::scored(correspondences, pose, bound).pose;
  const detail::MatchedPoints matched(view, working, bound);
  const detail::Chances at_random =
      detail::random_chances(view, working, bound, bound, 4096, 32, detail::RareHits::extrapolated, matched);
  return {at_random, detail::kept_chances(correspondences, working, bound, bound, at_random, matched)};
}

AtPose chances_at(const Problem& problem, const RigidTransform& pose) {
  return chances_at(problem.correspondences(), pose, problem.sigma);
}

double largest(const AtPose& at) {
  double result = at.at_random.support.front();
  for (const auto& [chances, along] : at.kept) result = std::max(result, chances.support.front());
  return result;
}

TEST(KeptChances, OfRingsAreThoseOfTheRingsAlone) {
  // A hundred rows on 32 rings, each matched with its own ring: under the rotation of the rings a target is within the
  // bound of 0.45 m on 2 pi r with chances that have a mean of 0.006.
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 100,
                                                 .outlier_ratio = 1.0,
                                                 .sigma = 0.15,
                                                 .half_extent = 90.0,
                                                 .trial = trial,
                                                 .scene = synth::Scene::rings,
                                                 .parts = 32,
                                                 .outliers = synth::OutlierModel::alike});
    const AtPose at = chances_at(problem, problem.decoy_T_target_source);
    ASSERT_FALSE(at.kept.empty()) << trial;
    EXPECT_GT(largest(at), 0.003) << trial;
    EXPECT_LT(largest(at), 0.06) << trial;
  }
}

TEST(KeptChances, AreNoLessThanThoseOfRandomPairing) {
  for (const auto scene : {synth::Scene::rings, synth::Scene::corridor, synth::Scene::volume}) {
    const Problem problem = synth::hard_problem({.correspondences = 200,
                                                 .outlier_ratio = 1.0,
                                                 .sigma = 0.1,
                                                 .half_extent = 40.0,
                                                 .scene = scene,
                                                 .parts = 20,
                                                 .outliers = synth::OutlierModel::alike});
    const AtPose at = chances_at(problem, problem.decoy_T_target_source);
    EXPECT_FALSE(at.kept.empty());
    for (const auto& [chances, along] : at.kept) {
      for (std::size_t b = 0; b < chances.support.size(); ++b) {
        EXPECT_GE(chances.support[b], at.at_random.support[b]);
        EXPECT_LE(chances.support[b], 1.0);
        EXPECT_EQ(chances.length[b], at.at_random.length[b]);
      }
    }
  }
}

TEST(KeptChances, OfRangesAreThoseAboutTheSensorWhereverItIs) {
  // What a sensor sees ahead of it, in map coordinates: neither their origin nor the middle of the points is the
  // sensor, which is told or not.
  const std::array<double, 3> sensor{4e5, -3e5, 100.0};
  const Problem problem = synth::hard_problem({.correspondences = 2400,
                                               .outlier_ratio = 1.0,
                                               .sigma = 0.1,
                                               .half_extent = 40.0,
                                               .outliers = synth::OutlierModel::alike,
                                               .source_offset = sensor});
  std::vector<std::uint32_t> ahead;
  for (std::uint32_t row = 0; row < problem.size(); ++row) {
    if (source_point(problem, row).x() > sensor[0]) ahead.push_back(row);
  }
  Correspondences rows = problem.correspondences().subset(ahead);
  for (const bool is_told : {false, true}) {
    if (is_told) rows.set_source_viewpoint(sensor);
    const AtPose at = chances_at(rows, problem.decoy_T_target_source, problem.sigma);
    EXPECT_FALSE(at.kept.empty()) << is_told;
    // One mismatched pair in some fifty has ranges within the bound of 0.3 m, every row has.
    EXPECT_GT(largest(at), 20.0 * at.at_random.support.front()) << is_told;
  }
}

// In a map; a target's sensor.
const Eigen::Vector3d kTargetSensor(5e5, 5.4e6, 0.0);

// Rows of two unrelated scenes, matched at random but for height and range. The decoy motion takes one sensor, which is
// within 20 m in the map, to the other.
Problem unrelated_ranges(std::uint64_t trial) {
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> range(3.0, 40.0);
  std::uniform_real_distribution<double> height(-2.0, 6.0);
  std::uniform_real_distribution<double> azimuth(0.0, 2.0 * std::numbers::pi);
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  std::normal_distribution<double> noise(0.0, 0.05);
  const Eigen::Vector3d between(place(random), place(random), 0.0);
  Problem problem;
  problem.decoy_T_target_source.translation() = -between;
  for (std::size_t row = 0; row < std::array{60U, 200U, 800U}[trial % 3]; ++row) {
    const double r = range(random);
    const double z = height(random);
    const double from = azimuth(random);
    const double to = azimuth(random);
    const auto add = [&](std::vector<double>& points, const Eigen::Vector3d& sensor, double angle) {
      const Eigen::Vector3d point = sensor + Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z);
      points.insert(points.end(), {point.x() + noise(random), point.y() + noise(random), point.z() + noise(random)});
    };
    add(problem.source, kTargetSensor + between, from);
    add(problem.target, kTargetSensor, to);
  }
  problem.is_inlier.assign(problem.source.size() / 3, 0);
  return problem;
}

TEST(KeptChances, OfRangesAboutAnUnknownSensorGiveHardlyEverASuccess) {
  std::size_t successes = 0;
  for (std::uint64_t trial = 0; trial < trials(60); ++trial) {
    const Correspondences rows = unrelated_ranges(trial).correspondences();
    if (register_by_name("tcf", rows, {.noise_bound = 0.3, .seed = trial}).status == Status::success) ++successes;
  }
  // Three of another 300 are one: more than four of 60 are with a probability of 4e-4.
  EXPECT_LE(successes, 4U);
}

TEST(KeptViewpoint, IsTheSensorWhereverItIs) {
  for (std::uint64_t trial = 0; trial < 30; ++trial) {
    const Problem problem = unrelated_ranges(trial);
    const Correspondences rows = problem.correspondences();
    const Eigen::Vector3d sensor = problem.decoy_T_target_source.inverse() * kTargetSensor;
    const Eigen::Vector3d found =
        detail::kept_viewpoint(rows) / rows.view().scale() + Eigen::Vector3d(rows.source_centroid().data());
    // Heights are kept, so that ranges leave that of the viewpoint free.
    EXPECT_NEAR(found.x(), sensor.x(), 0.15) << trial;
    EXPECT_NEAR(found.y(), sensor.y(), 0.15) << trial;
  }
}

TEST(KeptViewpoint, IsFoundOfSmallScenesInAMapAndOfRowsThatAreListedTwice) {
  Problem problem = unrelated_ranges(1);
  const Eigen::Vector3d sensor = problem.decoy_T_target_source.inverse() * kTargetSensor;
  // The size of a hand: the origin of the map is a million lengths away.
  for (std::size_t k = 0; k < problem.source.size(); ++k) {
    const auto axis = static_cast<Eigen::Index>(k % 3);
    problem.source[k] = sensor[axis] + 0.01 * (problem.source[k] - sensor[axis]);
    problem.target[k] = kTargetSensor[axis] + 0.01 * (problem.target[k] - kTargetSensor[axis]);
  }
  const auto expect_found = [&] {
    const Correspondences rows = problem.correspondences();
    const Eigen::Vector3d found =
        detail::kept_viewpoint(rows) / rows.view().scale() + Eigen::Vector3d(rows.source_centroid().data());
    EXPECT_NEAR(found.x(), sensor.x(), 0.002);
    EXPECT_NEAR(found.y(), sensor.y(), 0.002);
  };
  expect_found();
  for (std::size_t k = problem.source.size(), all = k; k > 0; --k) {
    problem.source.push_back(problem.source[all - k] + 1e-5);
    problem.target.push_back(problem.target[all - k] + 1e-5);
  }
  problem.is_inlier.assign(problem.source.size() / 3, 0);
  expect_found();
}

// About right rows every point keeps its ranges.
TEST(KeptViewpoint, IsTheGivenOneWhereRowsAreRight) {
  for (std::uint64_t trial = 0; trial < 30; ++trial) {
    std::mt19937_64 random(trial);
    std::uniform_real_distribution<double> coordinate(-50.0, 50.0);
    std::normal_distribution<double> noise(0.0, 1.0);
    const double thickness = trial % 2 == 0 ? 1.0 : 0.05;
    const double sigma = std::array{0.0, 1e-3, 1e-2, 0.1}[trial % 4];
    const RigidTransform pose = motion(0.7, {1.0, 2.0, 3.0}, {10.0, -20.0, 30.0});
    Problem problem;
    for (std::size_t row = 0; row < 150; ++row) {
      const Eigen::Vector3d p(coordinate(random), coordinate(random), thickness * coordinate(random));
      const Eigen::Vector3d q =
          row % 3 != 0 ? pose * p : Eigen::Vector3d(coordinate(random), coordinate(random), coordinate(random));
      problem.source.insert(problem.source.end(), {p.x(), p.y(), p.z()});
      for (const double x : q) problem.target.push_back(x + sigma * noise(random));
    }
    problem.is_inlier.assign(150, 0);
    Correspondences rows = problem.correspondences();
    for (const double away : {0.0, 30.0, 1000.0, 1e5}) {
      rows.set_source_viewpoint({away, 0.3 * away, 0.1 * away});
      const Eigen::Vector3d given(rows.source_viewpoint().data());
      const Eigen::Vector3d expected = rows.view().scale() * (given - Eigen::Vector3d(rows.source_centroid().data()));
      EXPECT_EQ(detail::kept_viewpoint(rows), expected) << trial << ' ' << away;
    }
  }
}

TEST(KeptViewpoint, IsTheGivenOneWhereNothingIsKept) {
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    for (const std::size_t size : {3U, 31U, 32U, 60U, 300U, 3000U}) {
      const Problem problem = synth::hard_problem({.correspondences = size, .outlier_ratio = 0.95, .trial = trial});
      Correspondences rows = problem.correspondences();
      for (const double far : {0.0, 100.0, 1e6, 1e20, 1e200}) {
        rows.set_source_viewpoint({far, -far, 0.5 * far});
        const Eigen::Vector3d given(rows.source_viewpoint().data());
        const Eigen::Vector3d expected = rows.view().scale() * (given - Eigen::Vector3d(rows.source_centroid().data()));
        EXPECT_EQ(detail::kept_viewpoint(rows), expected) << trial << ' ' << size << ' ' << far;
      }
    }
  }
}

TEST(KeptViewpoint, IsANumberForPointsThatTellNone) {
  for (const double extent : {0.0, 1e-300, 1.0, 1e300}) {
    Problem problem;
    for (std::size_t row = 0; row < 40; ++row) {
      const double along = extent * static_cast<double>(row);  // a line, or one point
      problem.source.insert(problem.source.end(), {along, 0.0, 0.0});
      problem.target.insert(problem.target.end(), {0.0, along, 0.0});
    }
    problem.is_inlier.assign(40, 0);
    EXPECT_TRUE(detail::kept_viewpoint(problem.correspondences()).allFinite()) << extent;
  }
}

TEST(KeptChances, AreNumbersForViewpointsBeyondAllBounds) {
  const Problem problem = synth::hard_problem({.correspondences = 600, .outlier_ratio = 0.98, .sigma = 0.1});
  for (const double far : {1e20, 1e45, 1e200, std::numeric_limits<double>::max()}) {
    Correspondences rows = problem.correspondences();
    rows.set_source_viewpoint({far, -far, far});
    const AtPose at = chances_at(rows, problem.T_target_source, problem.sigma);
    EXPECT_LE(largest(at), 1.0);
    const double value =
        significance(rows, detail::scored(rows, problem.T_target_source, 0.3).pose, 0.3, Scrutiny::close)
            .log10_false_poses;
    EXPECT_TRUE(std::isfinite(value)) << far;
  }
}

// Poles of two unrelated scenes, matched at random but for the height.
Problem unrelated_poles(std::uint64_t trial) {
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> place(-20.0, 20.0);
  std::uniform_real_distribution<double> height(0.0, 5.0);
  std::normal_distribution<double> noise(0.0, 0.03);
  const std::size_t poles = 3 + random() % 9;
  std::vector<std::array<double, 2>> of_source(poles);
  std::vector<std::array<double, 2>> of_target(poles);
  for (auto* scene : {&of_source, &of_target}) {
    for (auto& pole : *scene) pole = {place(random), place(random)};
  }
  Problem problem;
  for (std::size_t row = 0; row < std::array{40U, 80U, 200U, 500U}[trial % 4]; ++row) {
    const auto& from = of_source[random() % poles];
    const auto& to = of_target[random() % poles];
    const double z = height(random);
    problem.source.insert(problem.source.end(), {from[0], from[1], z});
    problem.target.insert(problem.target.end(), {to[0] + noise(random), to[1] + noise(random), z + noise(random)});
  }
  return problem;
}

// Two poles fit two others of the same distance, with all their rows.
TEST(KeptChances, OfFewPolesGiveHardlyEverASuccess) {
  std::size_t successes = 0;
  for (std::uint64_t trial = 0; trial < trials(60); ++trial) {
    const Correspondences rows = unrelated_poles(trial).correspondences();
    for (const std::optional<double> bound : {std::optional(0.1), std::optional<double>()}) {
      const Registration result = register_by_name("tcf", rows, {.noise_bound = bound, .seed = trial});
      if (result.status == Status::success) ++successes;
    }
  }
  // Two of another 400 registrations are one: more than four of 120 are with a probability of 4e-4.
  EXPECT_LE(successes, 4U);
}

TEST(KeptChances, AreNoneWhereNothingIsKept) {
  // Nine in ten of 285 unrelated rows keep nothing by chance.
  for (std::uint64_t trial = 0; trial < 50; ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 300, .outlier_ratio = 0.95, .trial = trial});
    EXPECT_TRUE(chances_at(problem, problem.T_target_source).kept.empty()) << trial;
  }
}

TEST(KeptChances, AreNoneWhereThePoseMissesNoRow) {
  for (std::size_t rows = 3; rows < 8; ++rows) {
    const Problem problem = synth::hard_problem({.correspondences = rows, .outlier_ratio = 0.0, .sigma = 0.1});
    EXPECT_TRUE(chances_at(problem, problem.T_target_source).kept.empty());
  }
}

}  // namespace
}  // namespace consimd::test
