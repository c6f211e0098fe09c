// What holds for the solvers that search a matrix of pairs: sc2_pcr, turboreg and pcr99.
#include <consimd/solvers/sc2_pcr.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/turboreg.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "comparison.hpp"
#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

const auto kCompatibilitySolvers =
    ::testing::Values(std::string("sc2_pcr"), std::string("turboreg"), std::string("pcr99"));

Registration run(const std::string& solver, const Problem& problem, double noise_bound, std::uint64_t seed = 1) {
  Registration result = register_by_name(solver, problem.correspondences(), {.noise_bound = noise_bound, .seed = seed});
  expect_sound(result, problem, noise_bound);
  return result;
}

class CompatibilityStudyCell : public ::testing::TestWithParam<std::tuple<std::string, double, double>> {};
INSTANTIATE_TEST_SUITE_P(SolversOutliersAndSigmas, CompatibilityStudyCell,
                         ::testing::Combine(kCompatibilitySolvers, ::testing::Values(0.0, 0.5, 0.9, 0.98),
                                            ::testing::Values(0.1, 5.0)));

TEST_P(CompatibilityStudyCell, SucceedsWithTheErrorOfLeastSquares) {
  const auto [solver, outlier_ratio, sigma] = GetParam();
  const double bound = synth::noise_study_bound(sigma);
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(10); ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem = synth::noise_study_problem(
        {.correspondences = 2000, .outlier_ratio = outlier_ratio, .sigma = sigma, .trial = trial});
    const Registration result = run(solver, problem, bound, trial);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_TRUE(succeeds(problem, result, bound));
    errors.add(problem, result.T_target_source);
    ASSERT_EQ(result.stages.size(), 4u);
    EXPECT_EQ(result.stages[0].name, solver == "pcr99" ? "ranking" : "compatibility");
    EXPECT_EQ(result.stages[0].output, problem.size());
    EXPECT_EQ(result.stages[3].name, "refinement");
    EXPECT_EQ(result.stages[3].output, result.inliers.size());
  }
  // Few trials of 40 inliers scatter more than the mean of many.
  if (kAllTrials) errors.expect_within(1.25);
}

class CompatibilitySolver : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Solvers, CompatibilitySolver, kCompatibilitySolvers,
                         [](const auto& test) { return test.param; });

TEST_P(CompatibilitySolver, FindsThirtyInliersAmongThreeThousand) {
  for (const double sigma : {0.1, 2.5, 5.0}) {
    std::uint64_t successes = 0;
    for (std::uint64_t trial = 0; trial < trials(10); ++trial) {
      const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.99, .sigma = sigma, .trial = trial});
      const double bound = synth::noise_study_bound(sigma);
      if (succeeds(problem, run(GetParam(), problem, bound, trial), bound)) ++successes;
    }
    EXPECT_GE(successes + 1, trials(10)) << "sigma " << sigma;
  }
}

TEST_P(CompatibilitySolver, HasTheSameBitsOnAnyNumberOfThreads) {
  // Threads beyond the processor's, so that arenas of four are real on small machines.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  for (const auto& [outlier_ratio, decoys] :
       {std::pair(0.3, 0.0), std::pair(0.95, 0.0), std::pair(0.7, 1.0), std::pair(1.0, 0.0)}) {
    SCOPED_TRACE(::testing::Message() << outlier_ratio << " outliers, decoy share " << decoys);
    const Problem problem =
        synth::hard_problem({.correspondences = 900, .outlier_ratio = outlier_ratio, .decoy_share = decoys});
    const Registration expected = run(GetParam(), problem, 3.0);
    for (const int threads : {1, 2, 4}) {
      tbb::task_arena(threads).execute([&] {
        for (int repetition = 0; repetition < 3; ++repetition) {
          const Registration result = run(GetParam(), problem, 3.0);
          EXPECT_EQ(result.threads, threads);
          expect_same(result, expected);
        }
      });
    }
  }
}

TEST_P(CompatibilitySolver, HasTheSameBitsOnEveryInstructionSet) {
  const Isa before = active_isa();
  for (const double outlier_ratio : {0.3, 0.95, 1.0}) {
    const Problem problem =
        synth::hard_problem({.correspondences = 900, .outlier_ratio = outlier_ratio, .decoy_share = 0.2});
    const Registration expected = run(GetParam(), problem, 3.0);
    for (const Isa isa : supported_isas()) {
      SCOPED_TRACE(::testing::Message() << to_string(isa) << ", " << outlier_ratio << " outliers");
      set_active_isa(isa);
      const Registration result = run(GetParam(), problem, 3.0);
      EXPECT_EQ(result.isa, isa);
      expect_same(result, expected);
    }
    set_active_isa(before);
  }
}

TEST_P(CompatibilitySolver, StatusNamesWhatIsThere) {
  struct Case {
    synth::HardProblemOptions problem;
    Status status;
  };
  const Case cases[] = {
      {{.correspondences = 4, .outlier_ratio = 0.0, .sigma = 0.05}, Status::success},
      {{.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::linear, .thickness = 0.0},
       Status::degenerate_geometry},
      {{.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::planar, .thickness = 0.0},
       Status::success},
      {{.correspondences = 1000, .outlier_ratio = 0.7, .sigma = 0.1, .decoy_share = 1.0}, Status::ambiguous},
      {{.correspondences = 500, .outlier_ratio = 1.0, .sigma = 0.1}, Status::no_consensus},
  };
  for (const Case& c : cases) {
    const Registration result = run(GetParam(), synth::hard_problem(c.problem), 0.3);
    EXPECT_EQ(result.status, c.status) << to_string(result.status) << " instead of " << to_string(c.status);
  }
}

TEST_P(CompatibilitySolver, DegenerateInputHasNoPose) {
  const RigidTransform truth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  for (const std::size_t size : {0U, 1U, 2U, 3U, 200U}) {
    for (const Eigen::Vector3d& step : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.5, 1.0, -0.3)}) {
      SCOPED_TRACE(::testing::Message() << size << " rows with a step of " << step.norm());
      std::vector<Eigen::Vector3d> points;
      for (std::size_t k = 0; k < size; ++k) points.emplace_back(static_cast<double>(k) * step);
      const Registration result = run(GetParam(), perfect_problem(points, truth), 0.3);
      EXPECT_EQ(result.status, size < 3 ? Status::too_few_correspondences : Status::degenerate_geometry);
    }
  }
}

TEST_P(CompatibilitySolver, GivesNoPoseWhereThereIsNone) {
  for (const auto outliers : kOutlierModels) {
    for (const std::size_t size : {5U, 30U, 300U}) {
      for (std::uint64_t trial = 0; trial < trials(10); ++trial) {
        const Problem problem =
            synth::hard_problem({.correspondences = size, .outlier_ratio = 1.0, .trial = trial, .outliers = outliers});
        EXPECT_FALSE(run(GetParam(), problem, 3.0, trial).has_pose()) << size << " rows, trial " << trial;
      }
    }
  }
}

TEST_P(CompatibilitySolver, UnitDoesNotMatter) {
  const Problem metres = synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 0.8});
  const Registration expected = run(GetParam(), metres, 3.0);
  for (const double factor : {0x1p-10, 0x1p10}) {
    const Registration result = run(GetParam(), in_units(metres, factor), 3.0 * factor);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_EQ(result.inliers, expected.inliers);
    EXPECT_EQ(result.T_target_source.linear(), expected.T_target_source.linear());
  }
}

TEST_P(CompatibilitySolver, ExtremeBoundsAreSafe) {
  const Problem problem = synth::noise_study_problem({.correspondences = 200, .outlier_ratio = 0.5});
  for (const double bound : {1e-300, 1e-30, 1e-9, 1e3, 1e6, 1e30, 1e300}) {
    SCOPED_TRACE(::testing::Message() << "noise bound " << bound);
    EXPECT_FALSE(run(GetParam(), problem, bound).has_pose());
  }
}

template <typename Options>
Registration run_with(const Correspondences& correspondences, const Options& options) {
  if constexpr (std::is_same_v<Options, Sc2PcrOptions>) {
    return register_sc2_pcr(correspondences, options);
  } else {
    return register_turboreg(correspondences, options);
  }
}

template <typename Options>
class CompatibilityOptions : public ::testing::Test {};
using AllOptions = ::testing::Types<Sc2PcrOptions, TurboRegOptions>;
TYPED_TEST_SUITE(CompatibilityOptions, AllOptions);

TYPED_TEST(CompatibilityOptions, SampleOfTheRowsWithinTheBudget) {
  const Problem problem = synth::noise_study_problem({.correspondences = 2000, .outlier_ratio = 0.5});
  const Correspondences correspondences = problem.correspondences();
  TypeParam options{.noise_bound = 3.0};
  options.matrix_budget_bytes = 2 * ConsistencyMatrix::memory_bytes(500);
  const Registration sampled = run_with(correspondences, options);
  expect_sound(sampled, problem, 3.0);
  EXPECT_EQ(sampled.status, Status::success);
  EXPECT_TRUE(succeeds(problem, sampled, 3.0));
  const StageReport& compatibility = sampled.stages.front();
  EXPECT_EQ(compatibility.input, 2000u);
  EXPECT_GE(compatibility.output, 500u);
  EXPECT_LT(compatibility.output, 800u);
  EXPECT_GT(sampled.inliers.size(), 900u);  // of all rows

  const Registration again = run_with(correspondences, options);
  expect_same(again, sampled);
}

TYPED_TEST(CompatibilityOptions, BadOnesAreRejected) {
  const Correspondences some = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const Correspondences nothing;
  for (const Correspondences& correspondences : {std::cref(some), std::cref(nothing)}) {
    const auto expect_bad = [&](const std::string& name, double value, const std::function<void(TypeParam&)>& change) {
      TypeParam options{.noise_bound = 1.0};
      change(options);
      expect_rejected([&] { static_cast<void>(run_with(correspondences, options)); }, name, value);
    };
    for (const double length : kBadLengths) {
      expect_bad("noise_bound", length, [&](TypeParam& o) { o.noise_bound = length; });
      expect_bad("length_tolerance", length, [&](TypeParam& o) { o.length_tolerance = length; });
    }
    expect_bad("matrix_budget_bytes", 100.0, [](TypeParam& o) { o.matrix_budget_bytes = 100; });
    if constexpr (std::is_same_v<TypeParam, TurboRegOptions>) {
      for (const double length : kBadLengths) {
        expect_bad("separation", length, [&](TypeParam& o) { o.separation = length; });
      }
      expect_bad("pivots", 0.0, [](TypeParam& o) { o.pivots = 0; });
      expect_bad("cliques_per_pivot", 0.0, [](TypeParam& o) { o.cliques_per_pivot = 0; });
    } else {
      for (const double length : kBadLengths) {
        expect_bad("seed_radius", length, [&](TypeParam& o) { o.seed_radius = length; });
      }
      for (const double share : {0.0, -0.5, 1.5, kNan}) {
        expect_bad("seed_share", share, [&](TypeParam& o) { o.seed_share = share; });
      }
      expect_bad("power_iterations", 0.0, [](TypeParam& o) { o.power_iterations = 0; });
      expect_bad("first_set", 2.0, [](TypeParam& o) { o.first_set = 2; });
      expect_bad("first_set", 65.0, [](TypeParam& o) { o.first_set = 65; });
      expect_bad("second_set", 2.0, [](TypeParam& o) { o.second_set = 2; });
      expect_bad("second_set", 31.0, [](TypeParam& o) { o.second_set = 31; });
    }
  }
}

TYPED_TEST(CompatibilityOptions, EitherRankingFindsThePose) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.9});
  for (const PoseRanking ranking : {PoseRanking::inlier_count, PoseRanking::truncated_score}) {
    TypeParam options{.noise_bound = 3.0};
    options.ranking = ranking;
    EXPECT_TRUE(succeeds(problem, run_with(problem.correspondences(), options), 3.0));
  }
}

TYPED_TEST(CompatibilityOptions, BoundsTriedCountInTheSignificance) {
  const Correspondences correspondences = synth::noise_study_problem({.correspondences = 300}).correspondences();
  TypeParam options{.noise_bound = 3.0};
  const double once = run_with(correspondences, options).log10_false_poses;
  options.bounds_tried = 10;
  EXPECT_DOUBLE_EQ(run_with(correspondences, options).log10_false_poses, once + 1.0);
}

}  // namespace
}  // namespace consimd::test
