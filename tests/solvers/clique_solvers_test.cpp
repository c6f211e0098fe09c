// The solvers that look for cliques: teaser and mac.
#include <consimd/solvers/mac.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/teaser.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <functional>
#include <ostream>
#include <string>
#include <tuple>
#include <vector>

#include "comparison.hpp"
#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

using Selection = TeaserOptions::Selection;
using Pairs = GncRotationOptions::Pairs;

class CliqueSolverStudyCell : public ::testing::TestWithParam<std::tuple<std::string, double, double>> {};
INSTANTIATE_TEST_SUITE_P(SolversOutliersAndSigmas, CliqueSolverStudyCell,
                         ::testing::Combine(::testing::Values("teaser", "mac"), ::testing::Values(0.0, 0.5, 0.9, 0.98),
                                            ::testing::Values(0.1, 2.5)));

TEST_P(CliqueSolverStudyCell, SucceedsWithTheErrorOfLeastSquares) {
  const auto& [solver, outlier_ratio, sigma] = GetParam();
  const double bound = synth::noise_study_bound(sigma);
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(10); ++trial) {
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Problem problem = synth::noise_study_problem(
        {.correspondences = 1000, .outlier_ratio = outlier_ratio, .sigma = sigma, .trial = trial});
    const Registration result =
        register_by_name(solver, problem.correspondences(), {.noise_bound = bound, .seed = trial});
    expect_sound(result, problem, bound);
    EXPECT_EQ(result.status, Status::success);
    EXPECT_TRUE(succeeds(problem, result, bound));
    errors.add(problem, result.T_target_source);
    EXPECT_EQ(result.stages.front().name, solver == "mac" ? "maximal_cliques" : "maximum_clique");
    EXPECT_EQ(result.stages.back().output, result.inliers.size());
  }
  if (trials(10) == 10) errors.expect_within(1.15);
}

TEST(Teaser, EverySelectionAndAllPairsSucceedWhereOutliersAreFew) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.2, .sigma = 1.0});
  for (const Selection selection : {Selection::maximum_clique, Selection::maximum_core, Selection::everything}) {
    for (const Pairs pairs : {Pairs::chain, Pairs::all}) {
      const Registration result = register_teaser(
          problem.correspondences(), {.noise_bound = 3.0, .selection = selection, .rotation_pairs = pairs});
      expect_sound(result, problem, 3.0);
      EXPECT_TRUE(succeeds(problem, result, 3.0));
    }
  }
}

TEST(Teaser, RefinementImprovesTheTranslation) {
  Errors refined;
  Errors plain;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem =
        synth::noise_study_problem({.correspondences = 500, .outlier_ratio = 0.5, .sigma = 1.0, .trial = trial});
    TeaserOptions options{.noise_bound = 3.0};
    refined.add(problem, register_teaser(problem.correspondences(), options).T_target_source);
    options.refine = false;
    const Registration own = register_teaser(problem.correspondences(), options);
    expect_sound(own, problem, 3.0);
    EXPECT_TRUE(succeeds(problem, own, 3.0));
    EXPECT_TRUE(own.covariance.isZero(0.0));
    EXPECT_EQ(own.stages.back().name, "significance");
    plain.add(problem, own.T_target_source);
  }
  EXPECT_LE(refined.translation, plain.translation);
}

TEST(Teaser, UnprovenCliqueIsReported) {
  // A pose that is there, in a graph too dense to be searched through.
  const Problem problem = synth::noise_study_problem({.correspondences = 1500, .outlier_ratio = 0.97, .sigma = 5.0});
  const Registration proven = register_teaser(problem.correspondences(), {.noise_bound = 15.0});
  EXPECT_EQ(proven.status, Status::success);
  const Registration cut = register_teaser(problem.correspondences(), {.noise_bound = 15.0, .max_nodes = 0});
  expect_sound(cut, problem, 15.0);
  EXPECT_EQ(cut.stages.front().iterations, 0u);
  EXPECT_GT(proven.stages.front().iterations, 0u);
  EXPECT_EQ(cut.status, Status::budget_exhausted);
}

TEST(Mac, EveryOptionIsSoundAndFindsThePose) {
  const Problem problem = synth::noise_study_problem({.correspondences = 600, .outlier_ratio = 0.9, .sigma = 1.0});
  for (const MacOptions& options :
       {MacOptions{.noise_bound = 3.0}, MacOptions{.noise_bound = 3.0, .second_order = false},
        MacOptions{.noise_bound = 3.0, .weighted_fit = true}, MacOptions{.noise_bound = 3.0, .max_hypotheses = 100},
        MacOptions{.noise_bound = 3.0, .max_mean_degree = 8.0},
        MacOptions{.noise_bound = 3.0, .compatibility_distance = 2.0, .compatibility_threshold = 0.5},
        MacOptions{.noise_bound = 3.0, .max_mean_degree = kInfinity}}) {
    SCOPED_TRACE(::testing::Message() << "degree " << options.max_mean_degree << ", hypotheses "
                                      << options.max_hypotheses << ", second order " << options.second_order);
    const Registration result = register_mac(problem.correspondences(), options);
    expect_sound(result, problem, 3.0);
    EXPECT_TRUE(succeeds(problem, result, 3.0));
    EXPECT_LE(result.stages[1].iterations, options.max_hypotheses);
  }
}

TEST(Mac, BudgetIsKept) {
  const Problem problem = synth::noise_study_problem({.correspondences = 400, .outlier_ratio = 0.3, .sigma = 1.0});
  const Registration few =
      register_mac(problem.correspondences(), {.noise_bound = 3.0, .max_cliques = 800, .max_hypotheses = 20});
  expect_sound(few, problem, 3.0);
  EXPECT_LE(few.stages[0].iterations, 800u);
  EXPECT_LE(few.stages[1].iterations, 20u);
  EXPECT_TRUE(succeeds(problem, few, 3.0));
  const Registration one = register_mac(problem.correspondences(), {.noise_bound = 3.0, .max_hypotheses = 1});
  EXPECT_EQ(one.stages[1].iterations, 1u);
}

TEST(Mac, BudgetThatEndsIsNoDoubtWhereNoOtherPoseCouldHide) {
  // Without structure in the outliers: whatever the search left out, it is no pose of as much support.
  const Problem problem = synth::noise_study_problem({.correspondences = 2000, .outlier_ratio = 0.9, .sigma = 1.0});
  const Registration result =
      register_mac(problem.correspondences(), {.noise_bound = 3.0, .max_cliques = 5000, .max_nodes = 10'000});
  EXPECT_TRUE(succeeds(problem, result, 3.0));
  EXPECT_EQ(result.status, Status::success);
}

TEST(Teaser, WordsBoundTheSearch) {
  // Nearly every pair agrees by chance.
  const Problem problem = synth::hard_problem({.correspondences = 1500, .outlier_ratio = 1.0, .sigma = 15.0});
  const Registration whole =
      register_teaser(problem.correspondences(), {.noise_bound = 45.0, .max_work = 1'000'000'000});
  const Registration cut = register_teaser(problem.correspondences(), {.noise_bound = 45.0, .max_work = 1'000'000});
  for (const Registration* result : {&whole, &cut}) {
    expect_sound(*result, problem, 45.0);
    EXPECT_FALSE(result->has_pose());
  }
  EXPECT_LT(cut.stages.front().iterations, whole.stages.front().iterations);
}

TEST(Teaser, UnprovenCliqueIsNoDoubtWhereTheRestHoldsNoRival) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 1.0});
  const Registration cut = register_teaser(problem.correspondences(), {.noise_bound = 3.0, .max_nodes = 0});
  expect_sound(cut, problem, 3.0);
  EXPECT_TRUE(succeeds(problem, cut, 3.0));
  EXPECT_EQ(cut.status, Status::success);
}

TEST(CliqueSolvers, BadOptionsAreRejected) {
  const Correspondences some = synth::noise_study_problem({.correspondences = 50}).correspondences();
  const Correspondences nothing;
  for (const Correspondences& correspondences : {std::cref(some), std::cref(nothing)}) {
    const auto mac = [&](const MacOptions& options) {
      return [&correspondences, options] { static_cast<void>(register_mac(correspondences, options)); };
    };
    for (const double x : {0.0, -1.0, kNan, kInfinity}) {
      expect_rejected(mac({.noise_bound = 1.0, .compatibility_distance = x}), "compatibility_distance", x);
    }
    for (const double x : {-0.1, 1.0, 2.0, kNan}) {
      expect_rejected(mac({.noise_bound = 1.0, .compatibility_threshold = x}), "compatibility_threshold", x);
    }
    for (const double x : {0.0, -1.0, kNan}) {
      expect_rejected(mac({.noise_bound = 1.0, .max_mean_degree = x}), "max_mean_degree", x);
    }
  }
  expect_rejected([&] { static_cast<void>(register_mac(some, {.noise_bound = 1.0, .matrix_budget_bytes = 399})); },
                  "matrix_budget_bytes", 399);
  expect_rejected([&] { static_cast<void>(register_teaser(some, {.noise_bound = 1.0, .matrix_budget_bytes = 399})); },
                  "matrix_budget_bytes", 399);
  EXPECT_NO_THROW(static_cast<void>(register_teaser(some, {.noise_bound = 1.0, .matrix_budget_bytes = 400})));
}

class CliqueSolver : public ::testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] static Registration run(const Problem& problem, double bound, std::uint64_t seed = 1) {
    return register_by_name(GetParam(), problem.correspondences(), {.noise_bound = bound, .seed = seed});
  }
};
INSTANTIATE_TEST_SUITE_P(Names, CliqueSolver, ::testing::Values("teaser", "mac"),
                         [](const auto& test) { return test.param; });

TEST_P(CliqueSolver, IsSafeWithExtremeBounds) {
  const Problem problem = synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.5});
  for (const double bound : {1e-300, 1e-30, 1e-9, 1e3, 1e6, 1e30, 1e300}) {
    SCOPED_TRACE(bound);
    const Registration result = run(problem, bound);
    expect_sound(result, problem, bound);
    EXPECT_FALSE(result.has_pose());
  }
}

TEST_P(CliqueSolver, StatusNamesTheFaultOfDegenerateInput) {
  const RigidTransform truth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  for (const std::size_t size : {0U, 1U, 2U, 3U, 200U}) {
    for (const Eigen::Vector3d& step : {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.5, 1.0, -0.3)}) {
      SCOPED_TRACE(::testing::Message() << size << " rows with a step of " << step.norm());
      std::vector<Eigen::Vector3d> points;
      for (std::size_t k = 0; k < size; ++k) points.emplace_back(static_cast<double>(k) * step);
      const Problem problem = perfect_problem(points, truth);
      const Registration result = run(problem, 0.3);
      expect_sound(result, problem, 0.3);
      EXPECT_EQ(result.status, size < 3 ? Status::too_few_correspondences : Status::degenerate_geometry);
    }
  }
}

TEST_P(CliqueSolver, StatusesNameWhatIsThere) {
  using synth::HardProblemOptions;
  const std::vector<std::tuple<std::string, HardProblemOptions, Status>> cases{
      {"plane",
       {.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::planar, .thickness = 0.0},
       Status::success},
      {"line",
       {.correspondences = 1000, .outlier_ratio = 0.5, .sigma = 0.1, .scene = synth::Scene::linear, .thickness = 0.0},
       Status::degenerate_geometry},
      {"two_motions",
       {.correspondences = 1000, .outlier_ratio = 0.7, .sigma = 0.1, .decoy_share = 1.0},
       Status::ambiguous},
      {"no_pose", {.correspondences = 500, .outlier_ratio = 1.0, .sigma = 0.1}, Status::no_consensus}};
  for (const auto& [name, options, status] : cases) {
    SCOPED_TRACE(name);
    const Problem problem = synth::hard_problem(options);
    const Registration result = run(problem, 0.3);
    expect_sound(result, problem, 0.3);
    EXPECT_EQ(result.status, status) << to_string(result.status);
  }
}

TEST_P(CliqueSolver, GivesNoPoseWhereThereIsNone) {
  for (const synth::OutlierModel outliers : kOutlierModels) {
    for (const std::size_t size : {5U, 30U, 300U}) {
      for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
        const Problem problem =
            synth::hard_problem({.correspondences = size, .outlier_ratio = 1.0, .trial = trial, .outliers = outliers});
        const Registration result = run(problem, 3.0, trial);
        expect_sound(result, problem, 3.0);
        EXPECT_FALSE(result.has_pose()) << size << " rows, trial " << trial;
      }
    }
  }
}

TEST_P(CliqueSolver, IsTheSameForAnyNumberOfThreadsAndEveryInstructionSet) {
  // Threads beyond the processor's, so that arenas of four are real on small machines.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Isa before = active_isa();
  for (const synth::HardProblemOptions& options :
       {synth::HardProblemOptions{.correspondences = 600, .outlier_ratio = 0.3},
        synth::HardProblemOptions{.correspondences = 1000, .outlier_ratio = 0.95, .sigma = 3.0},
        synth::HardProblemOptions{.correspondences = 600, .outlier_ratio = 0.8, .decoy_share = 1.0},
        synth::HardProblemOptions{.correspondences = 300, .outlier_ratio = 1.0}}) {
    const Problem problem = synth::hard_problem(options);
    const double bound = 3.0 * options.sigma;
    const Registration expected = run(problem, bound);
    for (const int threads : {1, 2, 4}) {
      tbb::task_arena(threads).execute([&] {
        const Registration result = run(problem, bound);
        EXPECT_EQ(result.threads, threads);
        expect_same(result, expected);
      });
    }
    for (const Isa isa : supported_isas()) {
      SCOPED_TRACE(to_string(isa));
      set_active_isa(isa);
      expect_same(run(problem, bound), expected);
    }
    set_active_isa(before);
  }
}

}  // namespace
}  // namespace consimd::test
