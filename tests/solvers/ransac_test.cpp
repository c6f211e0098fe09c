// Three-point RANSAC, the baseline.
#include <consimd/solvers/ransac.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <functional>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "comparison.hpp"
#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

class RansacStudyCell : public ::testing::TestWithParam<std::tuple<double, double>> {};
INSTANTIATE_TEST_SUITE_P(OutliersAndSigmas, RansacStudyCell,
                         ::testing::Combine(::testing::Values(0.0, 0.1, 0.5, 0.9), ::testing::Values(0.1, 1.0, 5.0)));

TEST_P(RansacStudyCell, SucceedsWithTheErrorOfLeastSquares) {
  const auto [outlier_ratio, sigma] = GetParam();
  const double bound = synth::noise_study_bound(sigma);
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(40); ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.outlier_ratio = outlier_ratio, .sigma = sigma, .trial = trial});
    const Registration result = register_ransac(problem.correspondences(), {.noise_bound = bound, .seed = trial});
    expect_sound(result, problem, bound);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_TRUE(succeeds(problem, result, bound));
    errors.add(problem, result.T_target_source);
    ASSERT_EQ(result.stages.size(), 2u);
    EXPECT_EQ(result.stages[0].name, "three_point");
    EXPECT_EQ(result.stages[1].name, "refinement");
    EXPECT_EQ(result.stages[1].output, result.inliers.size());
  }
  // The statistical limit at 90 % outliers and 5 m is 1.04; single trials scatter more.
  if (trials(40) == 40) errors.expect_within(1.1);
}

TEST(Ransac, FiftyThousandSamplesFindOneInTwenty) {
  // 6.2 samples of inliers are to be expected; there are none in one trial of 500.
  std::uint64_t successes = 0;
  for (std::uint64_t trial = 0; trial < trials(60); ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.95, .sigma = 1.0, .trial = trial});
    const Registration result =
        register_by_name("ransac-50k", problem.correspondences(), {.noise_bound = 3.0, .seed = trial});
    expect_sound(result, problem, 3.0);
    if (succeeds(problem, result, 3.0)) ++successes;
  }
  EXPECT_GE(successes + 2, trials(60));
}

TEST(Ransac, ContaminatedSamplesAreBroughtHome) {
  // 0.4 samples of inliers are to be expected, one trial in three has one. At this noise a sample with a wrong row is
  // often near enough: 94 of 100 trials succeed, 31 without local optimisation.
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  const std::uint64_t count = trials(20);
  for (std::uint64_t trial = 0; trial < count; ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.98, .sigma = 5.0, .trial = trial});
    const Correspondences correspondences = problem.correspondences();
    RansacOptions options{.noise_bound = 15.0, .seed = trial};
    if (succeeds(problem, register_ransac(correspondences, options), 15.0)) ++with;
    options.local_optimisation = false;
    if (succeeds(problem, register_ransac(correspondences, options), 15.0)) ++without;
  }
  EXPECT_LE(without, with);
  EXPECT_GE(10 * with, 7 * count);
  EXPECT_TRUE(count < 20 || without < with);
}

class RansacIterations : public ::testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Counts, RansacIterations, ::testing::Values(1, 15, 16, 17, 1000, 40'000));

TEST_P(RansacIterations, AreExactWithoutConfidence) {
  for (const double outlier_ratio : {0.0, 0.8, 1.0}) {
    const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = outlier_ratio});
    const Registration result = register_ransac(
        problem.correspondences(), {.noise_bound = 3.0, .max_iterations = GetParam(), .confidence = std::nullopt});
    expect_sound(result, problem, 3.0);
    EXPECT_EQ(result.stages.front().iterations, GetParam());
    EXPECT_NE(result.status, Status::budget_exhausted);
  }
}

TEST_P(RansacIterations, AreAnUpperBoundWithConfidence) {
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem =
        synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.95, .sigma = 0.1, .trial = trial});
    const Registration result =
        register_ransac(problem.correspondences(), {.noise_bound = 0.3, .seed = trial, .max_iterations = GetParam()});
    expect_sound(result, problem, 0.3);
    // 5 % of inliers ask for 55 258 samples.
    EXPECT_EQ(result.stages.front().iterations, GetParam());
    EXPECT_NE(result.status, Status::success);
    EXPECT_TRUE(!result.has_pose() || succeeds(problem, result, 0.3));
  }
}

class RansacStop : public ::testing::TestWithParam<std::tuple<double, double>> {};
INSTANTIATE_TEST_SUITE_P(SharesAndConfidences, RansacStop,
                         ::testing::Combine(::testing::Values(1.0, 0.8, 0.5, 0.2, 0.1),
                                            ::testing::Values(0.5, 0.9, 0.999, 0.999999)));

TEST_P(RansacStop, FollowsTheClosedForm) {
  const auto [inlier_share, confidence] = GetParam();
  int late = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    const Problem problem = synth::noise_study_problem(
        {.correspondences = 500, .outlier_ratio = 1.0 - inlier_share, .sigma = 0.0, .trial = trial});
    const Registration result =
        register_ransac(problem.correspondences(),
                        {.noise_bound = 0.5, .seed = trial, .max_iterations = 1'000'000, .confidence = confidence});
    EXPECT_EQ(result.status, Status::success);
    const StageReport& search = result.stages.front();
    const double share = static_cast<double>(search.output) / 500.0;
    EXPECT_NEAR(share, inlier_share, 0.005);
    const double good = share * share * share;
    const double needed = good == 1.0 ? 1.0 : std::ceil(std::log(1.0 - confidence) / std::log(1.0 - good));
    // It stops there, or, with one less than the confidence in probability, at the first sample of inliers.
    EXPECT_GE(static_cast<double>(search.iterations), needed);
    if (static_cast<double>(search.iterations) > needed) ++late;
  }
  // Mean and five deviations of a binomial.
  const double doubt = 1.0 - confidence;
  EXPECT_LE(late, 20.0 * doubt + 5.0 * std::sqrt(20.0 * doubt * confidence));
}

TEST(RansacOptionsTest, BadOnesAreRejected) {
  const Correspondences some = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const Correspondences nothing;
  for (const Correspondences& correspondences : {std::cref(some), std::cref(nothing)}) {
    const auto run = [&](const RansacOptions& options) {
      return [&correspondences, options] { static_cast<void>(register_ransac(correspondences, options)); };
    };
    for (const double bound : kBadLengths) expect_rejected(run({.noise_bound = bound}), "noise_bound", bound);
    for (const double confidence : kBadConfidences) {
      expect_rejected(run({.noise_bound = 1.0, .confidence = confidence}), "confidence", confidence);
    }
    for (const double tolerance : {0.0, -1.0, kNan, -kInfinity}) {
      expect_rejected(run({.noise_bound = 1.0, .length_tolerance = tolerance}), "length_tolerance", tolerance);
    }
    EXPECT_NO_THROW(run({.noise_bound = 1.0, .length_tolerance = kInfinity})());
  }
}

TEST(RansacOptionsTest, ExtremeValuesAreSafe) {
  const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5});
  for (const double bound : {1e-300, 1e-30, 1e-9, 1e3, 1e6, 1e30, 1e300}) {
    for (const double tolerance : {1e-300, 1.0, 1e300, kInfinity}) {
      SCOPED_TRACE(::testing::Message() << "noise bound " << bound << ", tolerance " << tolerance);
      const Registration result = register_ransac(
          problem.correspondences(), {.noise_bound = bound, .max_iterations = 1000, .length_tolerance = tolerance});
      expect_sound(result, problem, bound);
      EXPECT_FALSE(result.has_pose());
    }
  }
}

TEST(RansacOptionsTest, BoundsTriedCountInTheSignificance) {
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 300}).correspondences();
  const double once = register_ransac(correspondences, {.noise_bound = 3.0}).log10_false_poses;
  const double tenth = register_ransac(correspondences, {.noise_bound = 3.0, .bounds_tried = 10}).log10_false_poses;
  EXPECT_DOUBLE_EQ(tenth, once + 1.0);
}

TEST(RansacOptionsTest, SeedChangesTheSamples) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .sigma = 5.0});
  const auto run = [&](std::uint64_t seed) {
    return register_ransac(problem.correspondences(),
                           {.noise_bound = 15.0, .seed = seed, .max_iterations = 300, .local_optimisation = false});
  };
  std::set<std::size_t> supports;
  for (std::uint64_t seed = 0; seed < 20; ++seed) supports.insert(run(seed).stages.front().output);
  EXPECT_GT(supports.size(), 3u);
}

TEST(RansacOptionsTest, LocalOptimisationRaisesTheSupport) {
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 5.0, .trial = trial});
    RansacOptions options{.noise_bound = 15.0, .seed = trial, .max_iterations = 100, .confidence = std::nullopt};
    const std::size_t optimised = register_ransac(problem.correspondences(), options).stages.front().output;
    options.local_optimisation = false;
    const std::size_t minimal = register_ransac(problem.correspondences(), options).stages.front().output;
    EXPECT_GT(optimised, minimal) << "trial " << trial;
  }
}

/// Rows at the edge of the noise bound, every other one on the far side: their lengths differ by nearly 2 tau.
Problem at_the_edge(double noise_bound, std::uint64_t trial) {
  Problem problem =
      synth::noise_study_problem({.correspondences = 60, .outlier_ratio = 0.0, .sigma = 0.0, .trial = trial});
  for (std::size_t k = 0; k < problem.size(); ++k) {
    const Eigen::Vector3d out =
        (problem.T_target_source.linear() * source_point(problem, k)).normalized() * (k % 2 == 0 ? 0.999 : -0.999);
    Eigen::Map<Eigen::Vector3d>(&problem.target[3 * k]) += noise_bound * out;
  }
  return problem;
}

TEST(RansacLengthTolerance, OfTwoBoundsLosesNoSampleOfInliers) {
  bool one_bound_loses_some = false;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    const Correspondences correspondences = at_the_edge(5.0, trial).correspondences();
    const auto run = [&](double tolerance) {
      return register_ransac(correspondences, {.noise_bound = 5.0,
                                               .seed = trial,
                                               .max_iterations = 20,
                                               .confidence = std::nullopt,
                                               .length_tolerance = tolerance,
                                               .local_optimisation = false});
    };
    const Registration all = run(kInfinity);
    expect_same(run(2.0), all);
    if (run(1.0).T_target_source.matrix() != all.T_target_source.matrix()) one_bound_loses_some = true;
  }
  EXPECT_TRUE(one_bound_loses_some);
}

TEST(RansacLengthTolerance, OfNothingLeavesNothing) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5});
  const Registration result =
      register_ransac(problem.correspondences(), {.noise_bound = 3.0, .length_tolerance = 1e-6});
  expect_sound(result, problem, 3.0);
  EXPECT_EQ(result.status, Status::no_consensus);
  EXPECT_EQ(result.stages.front().output, 0u);
}

struct RansacCase {
  std::string name;
  synth::HardProblemOptions problem;
  RansacOptions options;
};

void PrintTo(const RansacCase& c, std::ostream* out) { *out << c.name; }

class RansacDeterminism : public ::testing::TestWithParam<RansacCase> {
 protected:
  [[nodiscard]] Registration run() const { return register_ransac(correspondences_, GetParam().options); }

  Correspondences correspondences_ = synth::hard_problem(GetParam().problem).correspondences();
  // Threads beyond the processor's, so that arenas of four are real on small machines.
  tbb::global_control threads_{tbb::global_control::max_allowed_parallelism, 4};
};
INSTANTIATE_TEST_SUITE_P(
    Cases, RansacDeterminism,
    ::testing::Values(RansacCase{"few_outliers", {.correspondences = 1000, .outlier_ratio = 0.3}, {.noise_bound = 3.0}},
                      RansacCase{"many_outliers",
                                 {.outlier_ratio = 0.95, .sigma = 5.0},
                                 {.noise_bound = 15.0, .max_iterations = 20'000}},
                      RansacCase{"plain",
                                 {.outlier_ratio = 0.9, .sigma = 5.0},
                                 {.noise_bound = 15.0,
                                  .max_iterations = 2000,
                                  .confidence = std::nullopt,
                                  .length_tolerance = kInfinity,
                                  .local_optimisation = false}},
                      RansacCase{"two_poses",
                                 {.correspondences = 1500, .outlier_ratio = 0.8, .decoy_share = 1.0},
                                 {.noise_bound = 3.0, .max_iterations = 5000}},
                      RansacCase{"no_pose", {.correspondences = 500, .outlier_ratio = 1.0}, {.noise_bound = 3.0}}),
    [](const auto& test) { return test.param.name; });

TEST_P(RansacDeterminism, AnyNumberOfThreads) {
  const Registration expected = run();
  for (const int threads : {1, 2, 4}) {
    SCOPED_TRACE(::testing::Message() << threads << " threads");
    tbb::task_arena(threads).execute([&] {
      for (int repetition = 0; repetition < 3; ++repetition) {
        const Registration result = run();
        EXPECT_EQ(result.threads, threads);
        expect_same(result, expected);
      }
    });
  }
}

TEST_P(RansacDeterminism, EveryInstructionSet) {
  const Isa before = active_isa();
  const Registration expected = run();
  for (const Isa isa : supported_isas()) {
    SCOPED_TRACE(to_string(isa));
    set_active_isa(isa);
    const Registration result = run();
    EXPECT_EQ(result.isa, isa);
    expect_same(result, expected);
  }
  set_active_isa(before);
}

TEST(RansacByName, MeansItsOptions) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 0.7}).correspondences();
  RansacOptions options{.noise_bound = 3.0, .seed = 7};
  const auto expect_named = [&](const std::string& name) {
    const Registration result = register_by_name(name, correspondences, {.noise_bound = 3.0, .seed = 7});
    expect_same(result, register_ransac(correspondences, options));
  };
  expect_named("ransac");
  options.confidence.reset();
  expect_named("ransac-50k");
  options.max_iterations = 10'000;
  expect_named("ransac-10k");
}

TEST(RansacDegenerate, StatusNamesTheFault) {
  const RigidTransform truth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  for (const std::size_t size : {0U, 1U, 2U, 3U, 200U}) {
    for (const Eigen::Vector3d& step : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.5, 1.0, -0.3)}) {
      SCOPED_TRACE(::testing::Message() << size << " rows with a step of " << step.norm());
      std::vector<Eigen::Vector3d> points;
      for (std::size_t k = 0; k < size; ++k) points.emplace_back(static_cast<double>(k) * step);
      const Problem problem = perfect_problem(points, truth);
      const Registration result = register_ransac(problem.correspondences(), {.noise_bound = 0.3});
      expect_sound(result, problem, 0.3);
      EXPECT_EQ(result.status, size < 3 ? Status::too_few_correspondences : Status::degenerate_geometry);
    }
  }
}

struct RansacStatus {
  std::string name;
  synth::HardProblemOptions problem;
  Status status;
};

void PrintTo(const RansacStatus& c, std::ostream* out) { *out << c.name; }

class RansacStatuses : public ::testing::TestWithParam<RansacStatus> {};
INSTANTIATE_TEST_SUITE_P(
    Cases, RansacStatuses,
    ::testing::Values(
        RansacStatus{"four_rows", {.correspondences = 4, .outlier_ratio = 0.0, .sigma = 0.05}, Status::success},
        RansacStatus{"line",
                     {.outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::linear, .thickness = 0.0},
                     Status::degenerate_geometry},
        RansacStatus{"plane",
                     {.outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::planar, .thickness = 0.0},
                     Status::success},
        RansacStatus{"two_motions", {.outlier_ratio = 0.7, .sigma = 0.1, .decoy_share = 1.0}, Status::ambiguous},
        RansacStatus{"no_pose", {.correspondences = 500, .outlier_ratio = 1.0, .sigma = 0.1}, Status::no_consensus}),
    [](const auto& test) { return test.param.name; });

TEST_P(RansacStatuses, NameWhatIsThere) {
  const Problem problem = synth::hard_problem(GetParam().problem);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Registration result = register_ransac(problem.correspondences(), {.noise_bound = 0.3, .seed = seed});
    expect_sound(result, problem, 0.3);
    EXPECT_EQ(result.status, GetParam().status) << to_string(result.status);
  }
}

class RansacWithoutPose : public ::testing::TestWithParam<std::tuple<synth::OutlierModel, std::size_t>> {};
INSTANTIATE_TEST_SUITE_P(OutliersAndSizes, RansacWithoutPose,
                         ::testing::Combine(::testing::ValuesIn(kOutlierModels), ::testing::Values(5, 30, 300)));

TEST_P(RansacWithoutPose, GivesNone) {
  const auto [outliers, size] = GetParam();
  std::uint64_t poses = 0;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem =
        synth::hard_problem({.correspondences = size, .outlier_ratio = 1.0, .trial = trial, .outliers = outliers});
    const Registration result = register_ransac(problem.correspondences(), {.noise_bound = 3.0, .seed = trial});
    expect_sound(result, problem, 3.0);
    if (result.has_pose()) ++poses;
  }
  EXPECT_EQ(poses, 0u);
}

}  // namespace
}  // namespace consimd::test
