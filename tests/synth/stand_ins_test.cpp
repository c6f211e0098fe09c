#include <consimd/synth/stand_ins.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <ostream>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "mutual_matches.hpp"
#include "random_stream.hpp"

namespace consimd::synth {

void PrintTo(const StandIn& stand_in, std::ostream* out) { *out << stand_in.name; }

namespace {

using Point = std::array<double, 3>;

Point point(const std::vector<double>& cloud, std::size_t k) {
  return {cloud[3 * k], cloud[3 * k + 1], cloud[3 * k + 2]};
}

Eigen::Vector3d vector(const std::vector<double>& cloud, std::size_t k) { return Eigen::Vector3d(&cloud[3 * k]); }

double residual(const Problem& problem, std::size_t k) {
  return (problem.T_target_source * vector(problem.source, k) - vector(problem.target, k)).norm();
}

/// Four standard errors of the mean of `trials` values that scatter uniformly by `share`.
double margin(double share, double trials) { return 4.0 * share / std::sqrt(3.0 * trials); }

class StandIns : public ::testing::TestWithParam<StandIn> {};
INSTANTIATE_TEST_SUITE_P(All, StandIns, ::testing::ValuesIn(stand_ins().begin(), stand_ins().end()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(StandIns, HaveTheNumbersOfThePapersTable) {
  const StandIn& s = GetParam();
  constexpr int kTrials = 8;
  double rows = 0.0, inliers = 0.0, distance = 0.0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    const Problem problem = stand_in_problem(s, 1, trial);
    const auto size = static_cast<double>(problem.size());
    const auto labelled = static_cast<double>(std::ranges::count(problem.is_inlier, 1));
    const double apart = problem.T_target_source.translation().norm();
    EXPECT_NEAR(size / static_cast<double>(s.correspondences), 1.0, 0.301);
    EXPECT_NEAR(labelled / size / s.inlier_ratio, 1.0, 0.61);
    EXPECT_NEAR(apart / s.pair_distance, 1.0, 0.201);
    rows += size / kTrials;
    inliers += labelled / kTrials;
    distance += apart / kTrials;
  }
  EXPECT_NEAR(rows / static_cast<double>(s.correspondences), 1.0, margin(0.3, kTrials));
  EXPECT_NEAR(distance / s.pair_distance, 1.0, margin(0.2, kTrials));
  // Both factors scatter.
  EXPECT_NEAR(inliers / (s.inlier_ratio * static_cast<double>(s.correspondences)), 1.0, margin(0.7, kTrials));
}

TEST_P(StandIns, LabelByThePapersRule) {
  const Problem problem = stand_in_problem(GetParam(), 2, 0);
  double squares = 0.0, inliers = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const double r = residual(problem, k);
    if (std::abs(r - GetParam().inlier_distance) < 1e-9) continue;
    EXPECT_EQ(problem.is_inlier[k] == 1, r < GetParam().inlier_distance) << "row " << k << ", residual " << r;
    if (problem.is_inlier[k] == 0) continue;
    squares += r * r;
    inliers += 1.0;
  }
  EXPECT_NEAR(problem.sigma, std::sqrt(squares / (3.0 * inliers)), 1e-9);
}

TEST_P(StandIns, MatchAsMutualTopThreeDoes) {
  const Problem problem = stand_in_problem(GetParam(), 3, 0);
  std::map<Point, int> of_source, of_target;
  std::set<std::pair<Point, Point>> pairs;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    ++of_source[point(problem.source, k)];
    ++of_target[point(problem.target, k)];
    pairs.emplace(point(problem.source, k), point(problem.target, k));
  }
  EXPECT_EQ(pairs.size(), problem.size());
  for (const auto* degrees : {&of_source, &of_target}) {
    std::size_t several = 0;
    for (const auto& [place, degree] : *degrees) {
      EXPECT_LE(degree, 3);
      several += degree > 1;
    }
    EXPECT_GT(several, degrees->size() / 4);
  }
}

TEST_P(StandIns, OutliersJoinPlacesThatLookAlike) {
  // Ground is matched to ground and a window sill to one of its row: wrong pairs differ less in height than random
  // ones.
  const Problem problem = stand_in_problem(GetParam(), 4, 0);
  std::vector<double> source, target;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 1) continue;
    source.push_back((problem.T_target_source * vector(problem.source, k)).z());
    target.push_back(vector(problem.target, k).z());
  }
  double matched = 0.0, shifted = 0.0;
  for (std::size_t k = 0; k < source.size(); ++k) {
    matched += std::abs(source[k] - target[k]);
    shifted += std::abs(source[k] - target[(k + source.size() / 2) % target.size()]);
  }
  EXPECT_LT(matched, 0.7 * shifted);
}

TEST_P(StandIns, NearMissesSurroundTheInliers) {
  // More rows just beyond the limit of a valid match than a uniform density of outliers would put there.
  const double limit = GetParam().inlier_distance;
  double near = 0.0, far = 0.0;
  for (std::uint64_t trial = 0; trial < 3; ++trial) {
    const Problem problem = stand_in_problem(GetParam(), 5, trial);
    for (std::size_t k = 0; k < problem.size(); ++k) {
      const double r = residual(problem, k);
      near += r > limit && r < 1.5 * limit;
      far += r > 4.0 * limit && r < 8.0 * limit;
    }
  }
  const double volume_ratio = (1.5 * 1.5 * 1.5 - 1.0) / (8.0 * 8.0 * 8.0 - 4.0 * 4.0 * 4.0);
  EXPECT_GT(near, 2.0 * volume_ratio * far);
}

TEST_P(StandIns, DependOnSeedAndTrialAlone) {
  const Problem problem = stand_in_problem(GetParam(), 7, 3);
  const Problem again = stand_in_problem(GetParam(), 7, 3);
  EXPECT_EQ(problem.source, again.source);
  EXPECT_EQ(problem.target, again.target);
  EXPECT_EQ(problem.is_inlier, again.is_inlier);
  EXPECT_NE(problem.source, stand_in_problem(GetParam(), 7, 4).source);
  EXPECT_NE(problem.source, stand_in_problem(GetParam(), 8, 3).source);
}

TEST(StandIn, IsFoundByItsName) {
  EXPECT_EQ(stand_ins().size(), 10u);
  for (const StandIn& s : stand_ins()) EXPECT_EQ(&stand_in(s.name), &s);
  try {
    static_cast<void>(stand_in("Arch"));
    ADD_FAILURE() << "a wrong name was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()).find("stand-in is 'Arch', expected one of: arch, courtyard"), 0u);
  }
}

TEST(MutualMatches, AreThoseOfSortedDistances) {
  RandomStream random({1, 2, 3}, Purpose::points);
  const auto any_descriptors = [&random](std::size_t count) {
    std::vector<Descriptor> descriptors(count);
    for (Descriptor& d : descriptors) {
      d.kind = static_cast<std::uint8_t>(random.below(3));
      for (float& x : d.look) x = static_cast<float>(random.uniform());
    }
    return descriptors;
  };
  const std::vector<Descriptor> source = any_descriptors(90), target = any_descriptors(70);
  // The `k` nearest of `from` among `to`.
  const auto nearest = [](const Descriptor& from, const std::vector<Descriptor>& to, std::size_t k) {
    std::vector<std::pair<float, std::uint32_t>> order;
    for (std::uint32_t j = 0; j < to.size(); ++j) {
      float sum = 0.0F;
      for (std::size_t i = 0; i < 3; ++i) sum += (from.look[i] - to[j].look[i]) * (from.look[i] - to[j].look[i]);
      if (from.kind == to[j].kind) order.emplace_back(sum, j);
    }
    std::ranges::sort(order);
    order.resize(std::min(k, order.size()));
    std::set<std::uint32_t> chosen;
    for (const auto& [distance, index] : order) chosen.insert(index);
    return chosen;
  };
  for (const std::size_t k : {1u, 3u, 8u}) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected, found;
    for (std::uint32_t i = 0; i < source.size(); ++i) {
      for (const std::uint32_t j : nearest(source[i], target, k)) {
        if (nearest(target[j], source, k).contains(i)) expected.emplace_back(i, j);
      }
    }
    for (const Match& match : mutual_matches(source, target, k)) found.emplace_back(match.source, match.target);
    EXPECT_EQ(found, expected) << "k = " << k;
  }
  EXPECT_TRUE(mutual_matches({}, target, 3).empty());
  EXPECT_TRUE(mutual_matches(source, {}, 3).empty());
}

}  // namespace
}  // namespace consimd::synth
