// Degenerate and hostile data: the status must say what is wrong, and no wrong pose may pass for a success.
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/tcf.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr double kNoiseBound = 0.3;

const RigidTransform kTruth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});

Registration run(const Problem& problem, double noise_bound, std::uint64_t seed = 1) {
  TcfOptions options;
  options.noise_bound = noise_bound;
  options.seed = seed;
  return register_tcf(problem.correspondences(), options);
}

/// Coordinates uniform in [-1, 1).
Eigen::Vector3d random_point(std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(static_cast<std::int32_t>(random())) * 0x1p-31; };
  const double x = uniform();
  const double y = uniform();
  return {x, y, uniform()};
}

Problem with_noise(Problem problem, double half_width) {
  std::mt19937 random(3);
  for (std::size_t k = 0; k < problem.size(); ++k) {
    Eigen::Map<Eigen::Vector3d>(&problem.target[3 * k]) += half_width * random_point(random);
  }
  return problem;
}

Problem coincident(std::size_t size) {
  const std::vector<Eigen::Vector3d> points(size, Eigen::Vector3d(1.0, 2.0, 3.0));
  return perfect_problem(points, kTruth);
}

Problem on_a_line(std::size_t size) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 0; k < size; ++k) points.emplace_back(static_cast<double>(k) * Eigen::Vector3d(0.5, 1.0, -0.3));
  return perfect_problem(points, kTruth);
}

Problem at_two_places(std::size_t size) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 0; k < size; ++k)
    points.emplace_back(static_cast<double>(k % 2) * Eigen::Vector3d(50.0, 1.0, 2.0));
  return perfect_problem(points, kTruth);
}

struct DegenerateCase {
  std::string name;
  std::function<Problem()> make;
  Status status;  ///< of the default solver
};

void PrintTo(const DegenerateCase& degenerate, std::ostream* out) { *out << degenerate.name; }

Problem nothing() { return {}; }
Problem first_rows(std::size_t size) { return chosen_rows(on_a_line(5), random_order(size, 1)); }

class TcfDegenerate : public ::testing::TestWithParam<std::tuple<DegenerateCase, std::string_view>> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, TcfDegenerate,
    ::testing::Combine(
        ::testing::Values(DegenerateCase{"no_row", nothing, Status::too_few_correspondences},
                          DegenerateCase{"one_row", [] { return first_rows(1); }, Status::too_few_correspondences},
                          DegenerateCase{"two_rows", [] { return first_rows(2); }, Status::too_few_correspondences},
                          DegenerateCase{"coincident_3", [] { return coincident(3); }, Status::degenerate_geometry},
                          DegenerateCase{"coincident_100", [] { return coincident(100); }, Status::degenerate_geometry},
                          DegenerateCase{"nearly_coincident", [] { return with_noise(coincident(100), 0.1); },
                                         Status::degenerate_geometry},
                          DegenerateCase{"two_places", [] { return at_two_places(100); }, Status::degenerate_geometry},
                          DegenerateCase{"two_noisy_places", [] { return with_noise(at_two_places(100), 0.1); },
                                         Status::degenerate_geometry},
                          DegenerateCase{"line_3", [] { return on_a_line(3); }, Status::degenerate_geometry},
                          DegenerateCase{"line_100", [] { return on_a_line(100); }, Status::degenerate_geometry},
                          DegenerateCase{"noisy_line", [] { return with_noise(on_a_line(100), 0.1); },
                                         Status::degenerate_geometry}),
        ::testing::Values("tcf", "tcf-published")),
    [](const auto& test) {
      return std::get<0>(test.param).name + (std::get<1>(test.param) == "tcf" ? "_default" : "_published");
    });

TEST_P(TcfDegenerate, StatusNamesTheFault) {
  const auto& [degenerate, solver] = GetParam();
  const Problem problem = degenerate.make();
  for (const double noise_bound : {0.3, 1e-3, 1e-12, 1e3, 1e12}) {
    SCOPED_TRACE(::testing::Message() << "noise bound " << noise_bound);
    const Registration result = register_by_name(solver, problem.correspondences(), {.noise_bound = noise_bound});
    expect_sound(result, problem, noise_bound);
    EXPECT_FALSE(result.has_pose());
    // With another bound noise may hide what is wrong.
    if (solver == "tcf" && noise_bound == kNoiseBound) {
      EXPECT_EQ(result.status, degenerate.status);
    }
  }
}

TEST(TcfDegenerate, LineAmongOutliersGivesNoPose) {
  for (std::uint64_t trial = 0; trial < 5; ++trial) {
    const Problem problem = synth::hard_problem({.correspondences = 500,
                                                 .outlier_ratio = 0.5,
                                                 .sigma = 0.1,
                                                 .trial = trial,
                                                 .scene = synth::Scene::linear,
                                                 .thickness = 0.0});
    const Registration result = run(problem, kNoiseBound);
    expect_sound(result, problem, kNoiseBound);
    EXPECT_EQ(result.status, Status::degenerate_geometry) << "trial " << trial;
  }
}

class TcfFewCorrespondences : public ::testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Sizes, TcfFewCorrespondences, ::testing::Range(std::size_t{4}, std::size_t{11}));

TEST_P(TcfFewCorrespondences, WithoutOutliersGiveTheLeastSquaresPose) {
  double error = 0.0;
  double oracle_error = 0.0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.correspondences = GetParam(), .outlier_ratio = 0.0, .sigma = 0.1, .trial = trial});
    const Registration result = run(problem, 0.5);
    expect_sound(result, problem, 0.5);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), 0.5);
    error += synth::translation_error(result.T_target_source, problem.T_target_source);
    oracle_error += synth::translation_error(synth::oracle(problem), problem.T_target_source);
  }
  EXPECT_LT(error, 1.2 * oracle_error);
}

TEST(TcfFewCorrespondences, AreFoundAmongAsManyOutliers) {
  // With a bound of 3 sigma, one inlier in thirty is missed and may leave too few.
  for (const std::size_t inliers : {6u, 8u, 10u}) {
    int found = 0;
    for (std::uint64_t trial = 0; trial < 20; ++trial) {
      SCOPED_TRACE(::testing::Message() << inliers << " inliers, trial " << trial);
      const Problem problem = synth::noise_study_problem(
          {.correspondences = 2 * inliers, .outlier_ratio = 0.5, .sigma = 0.1, .trial = trial});
      const Registration result = run(problem, kNoiseBound, trial);
      expect_sound(result, problem, kNoiseBound);
      if (!result.has_pose()) continue;
      ++found;
      // An outlier that is near by chance weighs as much as one of six.
      EXPECT_LT(displacement(problem, result.T_target_source, problem.T_target_source), 2.0 * kNoiseBound);
    }
    EXPECT_GE(found, 18) << inliers;
  }
}

TEST(TcfThreeCorrespondences, GiveTheirPoseOrNone) {
  // Three rows hardly tell a motion from chance: no consensus is an answer, a wrong pose is not.
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.correspondences = 3, .outlier_ratio = 0.0, .sigma = 0.1, .trial = trial});
    const Registration result = run(problem, 0.5);
    expect_sound(result, problem, 0.5);
    EXPECT_TRUE(result.status == Status::success || result.status == Status::no_consensus);
    EXPECT_TRUE(!result.has_pose() || synth::rmse_true_inliers(problem, result.T_target_source) < 0.5);
  }
}

struct OutlierCase {
  std::string name;
  synth::HardProblemOptions options;
};

void PrintTo(const OutlierCase& outliers, std::ostream* out) { *out << outliers.name; }

class TcfPureOutliers : public ::testing::TestWithParam<std::tuple<OutlierCase, std::size_t>> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, TcfPureOutliers,
    ::testing::Combine(::testing::Values(OutlierCase{"uniform", {.outliers = synth::OutlierModel::uniform}},
                                         OutlierCase{"permuted", {.outliers = synth::OutlierModel::permuted}},
                                         OutlierCase{"clustered", {.outliers = synth::OutlierModel::clustered}},
                                         OutlierCase{"one_to_many", {.outliers = synth::OutlierModel::one_to_many}},
                                         OutlierCase{"many_to_many", {.outliers = synth::OutlierModel::many_to_many}},
                                         OutlierCase{"planar", {.scene = synth::Scene::planar}},
                                         OutlierCase{"planar_permuted",
                                                     {.scene = synth::Scene::planar,
                                                      .outliers = synth::OutlierModel::permuted}},
                                         OutlierCase{"duplicates", {.duplicates = 150}}),
                       ::testing::Values(5, 30, 300, 600)),
    [](const auto& test) { return std::get<0>(test.param).name + "_" + std::to_string(std::get<1>(test.param)); });

TEST_P(TcfPureOutliers, HaveNoPose) {
  const auto& [outliers, size] = GetParam();
  const std::uint64_t trials = size > 300 ? 10 : 40;
  std::uint64_t poses = 0;
  double least = 0.0;
  for (std::uint64_t trial = 0; trial < trials; ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    synth::HardProblemOptions options = outliers.options;
    options.correspondences = size;
    options.outlier_ratio = 1.0;
    options.trial = trial;
    const Problem problem = synth::hard_problem(options);
    const Registration result = run(problem, 3.0, trial);
    expect_sound(result, problem, 3.0);
    if (result.has_pose()) ++poses;
    least = std::min(least, result.log10_false_poses);
  }
  EXPECT_EQ(poses, 0u) << "least log10 of false poses " << least;
}

TEST(TcfOptionsTest, BadOnesAreRejected) {
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const auto run_with = [&](double noise_bound, double confidence) {
    return [&correspondences, noise_bound, confidence] {
      static_cast<void>(register_tcf(correspondences, {.noise_bound = noise_bound, .confidence = confidence}));
    };
  };
  for (const double bound : kBadLengths) expect_rejected(run_with(bound, 0.99), "noise_bound", bound);
  for (const double confidence : kBadConfidences) expect_rejected(run_with(1.0, confidence), "confidence", confidence);
}

TEST(TcfOptionsTest, ExtremeBoundsAreSafe) {
  const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5});
  for (const double bound : {1e-300, 1e-30, 1e-9, 1e3, 1e6, 1e30, 1e300}) {
    SCOPED_TRACE(::testing::Message() << "noise bound " << bound);
    try {
      const Registration result = run(problem, bound);
      expect_sound(result, problem, bound);
      EXPECT_FALSE(result.has_pose());
      expect_sound(register_by_name("tcf-published", problem.correspondences(), {.noise_bound = bound}), problem,
                   bound);
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
}

TEST(TcfOptionsTest, BoundsAndUnitsBeyondDoubleAreNamed) {
  const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5});
  for (const double bound : {2e307, 1e308}) {
    EXPECT_THROW(static_cast<void>(run(problem, bound)), std::invalid_argument);
  }
  Problem small = problem;
  for (double& x : small.source) x *= 1e-20;
  for (double& x : small.target) x *= 1e-20;
  EXPECT_THROW(static_cast<void>(run(small, 1e300)), std::invalid_argument);
  for (const double unit : {1e-200, 1e-110, 1e-60, 1e60, 1e110, 1e200}) {
    Problem in_unit = problem;
    for (double& x : in_unit.source) x *= unit;
    for (double& x : in_unit.target) x *= unit;
    const Correspondences rows = in_unit.correspondences();
    for (const std::optional<double> bound :
         {std::optional(synth::noise_study_bound(problem.sigma) * unit), std::optional<double>()}) {
      SCOPED_TRACE(::testing::Message() << "unit " << unit);
      if (unit > 1e-75 && unit < 1e70) {
        EXPECT_EQ(register_by_name("tcf", rows, {.noise_bound = bound}).status, Status::success);
        continue;
      }
      try {
        static_cast<void>(register_by_name("tcf", rows, {.noise_bound = bound}));
        ADD_FAILURE() << "no error";
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("choose another unit of length"), std::string::npos) << error.what();
      }
    }
  }
}

/// Ground on twelve rings about the sensor, matched along its ring to about half a radian, and some true rows above it:
/// the ground has other motions with nearly as many supporters, and a true row agrees in length with much of it.
Problem ringed_ground(std::size_t ground, std::size_t true_rows, std::uint32_t seed) {
  std::mt19937 random(seed);
  Problem problem;
  problem.T_target_source = motion(3.0 * random_point(random).x(), {0.0, 0.0, 1.0},
                                   6.0 * random_point(random).cwiseProduct(Eigen::Vector3d(1, 1, 0)));
  const auto add = [&](const Eigen::Vector3d& source, const Eigen::Vector3d& target, bool inlier) {
    problem.source.insert(problem.source.end(), source.begin(), source.end());
    problem.target.insert(problem.target.end(), target.begin(), target.end());
    problem.is_inlier.push_back(inlier ? 1 : 0);
  };
  for (std::size_t k = 0; k < ground; ++k) {
    const double radius = 4.0 * std::pow(1.25, static_cast<double>(k % 12));
    const double azimuth = std::numbers::pi * random_point(random).x();
    const Eigen::Vector3d turns = random_point(random) + random_point(random);  // triangular, of deviation 0.8
    const auto at = [&](double angle) {
      return Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                             -1.8 + 0.05 * random_point(random).x());
    };
    const Eigen::Vector3d source = at(azimuth);
    add(source, at(azimuth + 0.6 * turns.x()), false);
  }
  for (std::size_t k = 0; k < true_rows; ++k) {
    const Eigen::Vector3d place = random_point(random);
    const Eigen::Vector3d source(30.0 * place.x(), 30.0 * place.y(), 2.5 + 3.5 * place.z());
    add(source, problem.T_target_source * source + 0.17 * random_point(random), true);
  }
  return problem;
}

// Of 400 such problems 389 poses are found; 4 end as ambiguous with another pose first, 1 as a success of such.
TEST(TcfHostileInput, APoseIsFoundAboveARingedGround) {
  constexpr auto kTrials = static_cast<std::uint32_t>(trials(40));
  std::uint32_t right = 0;
  for (std::uint32_t trial = 0; trial < kTrials; ++trial) {
    const Problem problem = ringed_ground(1300, 90, trial + 1);
    const Registration result = run(problem, kNoiseBound, trial);
    right += is_right(problem, result, kNoiseBound) ? 1U : 0U;
    EXPECT_FALSE(result.status == Status::success && !is_right(problem, result, kNoiseBound)) << "trial " << trial;
  }
  EXPECT_GE(10 * right, 9 * kTrials) << right;
}

class TcfBudget : public ::testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(MaxSeeds, TcfBudget, ::testing::Values(1, 2, 10, 100, 1000));

TEST_P(TcfBudget, AnEarlyEndIsReported) {
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.95, .sigma = 0.1, .trial = trial});
    TcfOptions options;
    options.noise_bound = kNoiseBound;
    options.max_seeds = GetParam();
    const Registration result = register_tcf(problem.correspondences(), options);
    expect_sound(result, problem, kNoiseBound);
    EXPECT_LE(result.stages.front().iterations, GetParam());
    // 5 % of inliers ask for 135 seeds.
    EXPECT_TRUE(GetParam() >= 100 || result.status != Status::success);
    EXPECT_TRUE(GetParam() < 1000 || result.status == Status::success);
    EXPECT_TRUE(!result.has_pose() || synth::rmse_true_inliers(problem, result.T_target_source) < kNoiseBound);
  }
}

}  // namespace
}  // namespace consimd::test
