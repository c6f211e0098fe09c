// Patches of ground that matches keep at their range and height: what turns about the sensor agree on is no pose.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/noise_study.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>

#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr double kBound = 0.65;

// Patches of up to 60 rows on the ground about a sensor. Seven in ten lead to such a patch at the same range, the
// others anywhere; a share of the rows follows a motion.
Problem patch_matches(std::uint64_t trial, double right) {
  constexpr std::size_t kRows = 4000;
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, 0.1);
  const auto on_ground = [&](double range, double turn) {
    return Eigen::Vector3d(range * std::cos(turn), range * std::sin(turn), -1.8);
  };
  const auto any_range = [&] { return 4.0 * std::pow(15.0, unit(random)); };
  const auto any_turn = [&] { return 2.0 * std::numbers::pi * unit(random); };
  Problem problem;
  problem.sigma = 0.1;
  problem.T_target_source.linear() = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  problem.T_target_source.translation() = Eigen::Vector3d(9.0, -4.0, 0.1);
  while (problem.size() < kRows) {
    const double range = any_range();
    const Eigen::Vector3d source = on_ground(range, any_turn());
    const Eigen::Vector3d target = on_ground(unit(random) < 0.7 ? range : any_range(), any_turn());
    // The target patch is turned as it is about the sensor, so that its ring and its radius stay those.
    const double turn = std::atan2(target.y(), target.x()) - std::atan2(source.y(), source.x());
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const auto rows = static_cast<std::size_t>(std::min(60.0, 1.0 + std::floor(-8.0 * std::log(1.0 - unit(random)))));
    for (std::size_t row = 0; row < rows && problem.size() < kRows; ++row) {
      const Eigen::Vector3d aside(2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0, 0.3 * unit(random));
      const bool is_right = unit(random) < right;
      const Eigen::Vector3d from = source + aside;
      const Eigen::Vector3d to = is_right ? Eigen::Vector3d(problem.T_target_source * from) : target + turned * aside;
      for (int c = 0; c < 3; ++c) {
        problem.source.push_back(from[c] + noise(random));
        problem.target.push_back(to[c] + noise(random));
      }
      problem.is_inlier.push_back(is_right ? 1 : 0);
    }
  }
  return problem;
}

class TurnsAboutASensorOf : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Solvers, TurnsAboutASensorOf, ::testing::ValuesIn(kSolvers),
                         [](const auto& test) { return std::string(test.param); });

// Without turns 5 of the 40.
TEST(TurnsAboutASensor, AreHardlyEverASuccess) {
  for (const char* solver : {"tcf", "turboreg"}) {
    std::size_t successes = 0;
    for (std::uint64_t trial = 0; trial < 40; ++trial) {
      const Correspondences correspondences = patch_matches(trial, 0.0).correspondences();
      const Registration result = register_by_name(solver, correspondences, {.noise_bound = kBound, .seed = trial});
      successes += result.status == Status::success ? 1U : 0U;
    }
    EXPECT_LE(successes, 1U) << solver;
  }
}

TEST_P(TurnsAboutASensorOf, HideNoPose) {
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Problem problem = patch_matches(trial, 0.03);
    const Registration result =
        register_by_name(GetParam(), problem.correspondences(), {.noise_bound = kBound, .seed = trial});
    EXPECT_TRUE(result.has_pose()) << trial;
    EXPECT_LT((result.T_target_source.matrix() - problem.T_target_source.matrix()).norm(), 0.3) << trial;
  }
}

// Turns of uniform rows have a dozen supporters at this bound, once they are brought into place. That is no structure.
TEST(TurnsAboutASensor, HideNoFewRowsAmongUniformOnes) {
  int found = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.99, .sigma = 5.0, .trial = trial});
    const Registration result =
        register_by_name("tcf", problem.correspondences(), {.noise_bound = 15.0, .seed = trial + 1});
    found += result.status == Status::success ? 1 : 0;
  }
  EXPECT_EQ(found, 40);
}

}  // namespace
}  // namespace consimd::test
