// Poles that matches join whole: what two or three of them agree on is no pose.
#include <consimd/solvers/solver.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>

#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr double kSigma = 0.03;
constexpr double kBound = 0.3;

// Rows of poles on flat ground. Those of a pole lead to one pole of another place, to their own height on it; the share
// `right` of them follows a motion about the vertical instead.
Problem joined_poles(std::uint64_t trial, double right) {
  std::mt19937_64 random(trial);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> noise(0.0, kSigma);
  const double half_extent = 15.0 + 45.0 * unit(random);
  const auto place = [&] { return half_extent * (2.0 * unit(random) - 1.0); };
  struct Pole {
    Eigen::Vector2d source, elsewhere;
    double height;
  };
  std::vector<Pole> poles(8 + random() % 32);
  for (Pole& pole : poles) pole = {{place(), place()}, {place(), place()}, 2.0 + 6.0 * unit(random)};
  Problem problem;
  problem.sigma = kSigma;
  problem.T_target_source.linear() = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  problem.T_target_source.translation() = Eigen::Vector3d(4.0, -3.0, 0.1);
  const std::size_t rows = 200 + random() % 2800;
  for (std::size_t row = 0; row < rows; ++row) {
    const Pole& pole = poles[random() % poles.size()];
    const Eigen::Vector3d source(pole.source.x(), pole.source.y(), pole.height * unit(random));
    const bool is_right = unit(random) < right;
    const Eigen::Vector3d target = is_right ? Eigen::Vector3d(problem.T_target_source * source)
                                            : Eigen::Vector3d(pole.elsewhere.x(), pole.elsewhere.y(), source.z());
    for (int c = 0; c < 3; ++c) {
      problem.source.push_back(source[c] + noise(random));
      problem.target.push_back(target[c] + noise(random));
    }
    problem.is_inlier.push_back(is_right ? 1 : 0);
  }
  return problem;
}

class CoherentLines : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Solvers, CoherentLines, ::testing::ValuesIn(kSolvers),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(CoherentLines, OfUnrelatedPlacesAreHardlyEverASuccess) {
  // Of other 300 registrations by tcf none is one with the bound and two are without it; 57 of 200 were before lines
  // were looked at. More than three of 40 are with a probability of less than 1e-4 where one in a hundred is.
  std::size_t successes = 0;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Correspondences rows = joined_poles(trial, 0.0).correspondences();
    for (const std::optional<double> bound : {std::optional(kBound), std::optional<double>()}) {
      const Registration result = register_by_name(GetParam(), rows, {.noise_bound = bound, .seed = trial});
      if (result.status == Status::success) ++successes;
    }
  }
  EXPECT_LE(successes, 3U);
}

TEST_P(CoherentLines, HideNoPoseThatManyLinesSupport) {
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem = joined_poles(trial, 0.3);
    const Registration result =
        register_by_name(GetParam(), problem.correspondences(), {.noise_bound = kBound, .seed = trial});
    EXPECT_EQ(result.status, Status::success) << trial;
    expect_sound(result, problem, kBound);
  }
}

}  // namespace
}  // namespace consimd::test
