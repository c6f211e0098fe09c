// Solvers after TCF's filter.
#include <consimd/solvers/solver.hpp>
#include <consimd/solvers/tcf_filter.hpp>
#include <consimd/synth/hard_problems.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <functional>
#include <optional>
#include <string>

#include "outlier_models.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

constexpr SolverOptions filtered(double noise_bound, std::uint64_t seed = 1) {
  return {.noise_bound = noise_bound, .seed = seed, .filter = Filter::tcf};
}

void expect_stages(const Registration& result, const Problem& problem) {
  ASSERT_GE(result.stages.size(), 3u);
  EXPECT_EQ(result.stages[0].name, "filter_one_point");
  EXPECT_EQ(result.stages[0].input, problem.size());
  EXPECT_EQ(result.stages[1].name, "filter_two_point");
  EXPECT_EQ(result.stages[1].input, result.stages[0].output);
  EXPECT_LE(result.stages[1].output, result.stages[1].input);
  EXPECT_EQ(result.stages[2].input, result.stages[1].output);
  if (!result.has_pose()) return;
  EXPECT_EQ(result.stages.back().name, "all_rows");
  EXPECT_EQ(result.stages.back().input, problem.size());
  EXPECT_EQ(result.stages.back().output, result.inliers.size());
}

TEST(Filter, HasNames) {
  for (const Filter filter : {Filter::none, Filter::tcf}) EXPECT_EQ(filter_by_name(to_string(filter)), filter);
  for (const std::string name : {"", "TCF", "magic"}) {
    try {
      static_cast<void>(filter_by_name(name));
      ADD_FAILURE() << "'" << name << "' was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(error.what(), "filter is '" + name + "', expected one of: none, tcf");
    }
  }
}

TEST(Filter, EverySolverFindsThePoseOnAllRows) {
  for (const std::string& solver : solver_names()) {
    for (const double outlier_ratio : {0.5, 0.9}) {
      SCOPED_TRACE(::testing::Message() << solver << " at " << outlier_ratio);
      // Hardly rotated, as tcf-published needs it.
      Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = outlier_ratio});
      const RigidTransform back = motion(0.02, {3.0, 2.0, 1.0}, {0.0, 10.0, 20.0}) * problem.T_target_source.inverse();
      problem = with_moved_target(std::move(problem), back);
      const Registration result = register_by_name(solver, problem.correspondences(), filtered(3.0));
      expect_sound(result, problem, 3.0);
      expect_stages(result, problem);
      EXPECT_TRUE(result.has_pose()) << to_string(result.status);
      EXPECT_LT(synth::rmse_true_inliers(problem, result.T_target_source), 3.0);
    }
  }
}

TEST(Filter, LiftsTheRecallOfFewSamples) {
  std::uint64_t alone = 0;
  std::uint64_t after_filter = 0;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.97, .sigma = 0.5, .trial = trial});
    const auto succeeds = [&](const SolverOptions& options) {
      const Registration result = register_by_name("ransac-10k", problem.correspondences(), options);
      expect_sound(result, problem, 1.5);
      return result.has_pose() && synth::rmse_true_inliers(problem, result.T_target_source) < 1.5;
    };
    alone += succeeds({.noise_bound = 1.5, .seed = trial});
    after_filter += succeeds(filtered(1.5, trial));
  }
  EXPECT_EQ(after_filter, trials(20));
  if (kAllTrials) {
    EXPECT_LT(alone, 15u);
  }
}

TEST(Filter, KeepsTheErrorOfLeastSquares) {
  Errors errors;
  for (std::uint64_t trial = 0; trial < trials(20); ++trial) {
    const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.9, .trial = trial});
    const Registration result = register_by_name("ransac", problem.correspondences(), filtered(3.0, trial));
    EXPECT_EQ(result.status, Status::success);
    errors.add(problem, result.T_target_source);
  }
  if (kAllTrials) errors.expect_within(1.1);
}

TEST(Filter, KeepsRowsThatAgreePairwise) {
  const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.9});
  const FilteredRows filtered_rows = tcf_filter(problem.correspondences(), {.noise_bound = 3.0});
  EXPECT_TRUE(std::ranges::is_sorted(filtered_rows.rows, std::ranges::less_equal{}));
  EXPECT_TRUE(filtered_rows.confident);
  std::size_t inliers = 0;
  for (const std::uint32_t row : filtered_rows.rows) inliers += problem.is_inlier[row];
  EXPECT_GT(inliers, 200u);
  EXPECT_GT(static_cast<double>(inliers), 0.9 * static_cast<double>(filtered_rows.rows.size()));
  EXPECT_FALSE(tcf_filter(problem.correspondences(), {.noise_bound = 3.0, .max_iterations = 2}).confident);
}

class FilterWithoutPose : public ::testing::TestWithParam<synth::OutlierModel> {};
INSTANTIATE_TEST_SUITE_P(OutlierModels, FilterWithoutPose, ::testing::ValuesIn(kOutlierModels));

TEST_P(FilterWithoutPose, GivesNone) {
  // The rows that the filter keeps agree pairwise, by chance: among all rows that is what chance gives.
  std::uint64_t poses = 0;
  for (std::uint64_t trial = 0; trial < trials(10); ++trial) {
    for (const std::size_t size : {5U, 30U, 300U}) {
      const Problem problem =
          synth::hard_problem({.correspondences = size, .outlier_ratio = 1.0, .trial = trial, .outliers = GetParam()});
      for (const std::string_view solver : {"tcf", "ransac-10k"}) {
        const Registration result = register_by_name(solver, problem.correspondences(), filtered(3.0, trial));
        expect_sound(result, problem, 3.0);
        poses += result.has_pose();
      }
    }
  }
  EXPECT_EQ(poses, 0u);
}

TEST(Filter, IsHeldAgainstAllRows) {
  // As many false poses as the same pose has without the filter, not what the kept rows alone would tell.
  const Problem problem = synth::noise_study_problem({.outlier_ratio = 0.95});
  const Registration with = register_by_name("tcf", problem.correspondences(), filtered(3.0));
  const Registration without = register_by_name("tcf", problem.correspondences(), {.noise_bound = 3.0});
  EXPECT_NEAR(with.log10_false_poses / without.log10_false_poses, 1.0, 0.05);
}

TEST(Filter, SameBitsForAnyThreadsAndInstructionSet) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 1500, .outlier_ratio = 0.95}).correspondences();
  const auto expect_same = [](const Registration& a, const Registration& b) {
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.T_target_source.matrix(), b.T_target_source.matrix());
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.inliers, b.inliers);
    EXPECT_EQ(a.log10_false_poses, b.log10_false_poses);
    ASSERT_EQ(a.stages.size(), b.stages.size());
    for (std::size_t s = 0; s < a.stages.size(); ++s) {
      EXPECT_EQ(a.stages[s].output, b.stages[s].output);
      EXPECT_EQ(a.stages[s].iterations, b.stages[s].iterations);
    }
  };
  const Registration expected = register_by_name("ransac", correspondences, filtered(3.0));
  EXPECT_EQ(expected.status, Status::success);
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena(threads).execute(
        [&] { expect_same(register_by_name("ransac", correspondences, filtered(3.0)), expected); });
  }
  const Isa before = active_isa();
  for (const Isa isa : supported_isas()) {
    set_active_isa(isa);
    expect_same(register_by_name("ransac", correspondences, filtered(3.0)), expected);
  }
  set_active_isa(before);
}

TEST(Filter, WorksWithoutABound) {
  const Problem problem = synth::noise_study_problem({.correspondences = 300, .outlier_ratio = 0.5});
  const Registration result = register_by_name("ransac", problem.correspondences(), {.filter = Filter::tcf});
  EXPECT_EQ(result.status, Status::success);
  EXPECT_NEAR(result.noise_bound, 3.0, 0.6);
  EXPECT_EQ(result.stages[0].name, "noise_bound");
  EXPECT_EQ(result.stages[1].name, "filter_one_point");
}

TEST(Filter, DegenerateInput) {
  const RigidTransform truth = motion(2.0, {1.0, -2.0, 0.5}, {10.0, 20.0, -30.0});
  for (const std::size_t size : {0U, 2U, 3U, 100U}) {
    SCOPED_TRACE(size);
    std::vector<Eigen::Vector3d> points;
    for (std::size_t k = 0; k < size; ++k)
      points.emplace_back(static_cast<double>(k) * Eigen::Vector3d(0.5, 1.0, -0.3));
    const Problem problem = perfect_problem(points, truth);
    const Registration result = register_by_name("tcf", problem.correspondences(), filtered(0.3));
    expect_sound(result, problem, 0.3);
    EXPECT_EQ(result.status, size < 3 ? Status::too_few_correspondences : Status::degenerate_geometry)
        << to_string(result.status);
  }
}

TEST(Filter, RejectsBadBounds) {
  const Correspondences correspondences =
      synth::noise_study_problem({.correspondences = 100, .outlier_ratio = 0.5}).correspondences();
  const Correspondences nothing;
  for (const double bound : kBadLengths) {
    for (const Correspondences& input : {std::cref(correspondences), std::cref(nothing)}) {
      expect_rejected([&] { static_cast<void>(register_by_name("tcf", input, filtered(bound))); }, "noise_bound",
                      bound);
      expect_rejected([&] { static_cast<void>(tcf_filter(input, {.noise_bound = bound})); }, "noise_bound", bound);
    }
  }
  for (const double confidence : kBadConfidences) {
    expect_rejected(
        [&] { static_cast<void>(tcf_filter(correspondences, {.noise_bound = 1.0, .confidence = confidence})); },
        "confidence", confidence);
  }
}

}  // namespace
}  // namespace consimd::test
