// Rows far from all others, copies and absurd bounds: what they leave as it is, and what is said of them.
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/field_problems.hpp>
#include <consimd/synth/hard_problems.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "problems.hpp"

namespace consimd::test {
namespace {

using synth::FarSide;

constexpr std::array kDistances{3e5, 1e7, 1e12, 1e100, std::numeric_limits<double>::max()};
constexpr std::array kSides{FarSide::source, FarSide::target, FarSide::both};

/// 36 rows in a hundred metres, half of them wrong.
Problem surveyed(std::uint64_t trial) {
  return synth::hard_problem(
      {.correspondences = 36, .outlier_ratio = 0.4, .sigma = 0.01, .half_extent = 50.0, .trial = trial});
}

/// The rows of `with` that are rows of `without`, which has the same in the same order and others not.
std::vector<std::uint32_t> common_rows(const Problem& with, const Problem& without) {
  std::vector<std::uint32_t> rows;
  for (std::uint32_t k = 0; k < with.size() && rows.size() < without.size(); ++k) {
    if (source_point(with, k) == source_point(without, rows.size()) &&
        target_point(with, k) == target_point(without, rows.size())) {
      rows.push_back(k);
    }
  }
  return rows;
}

void expect_same_but_for_rows(const Registration& with, const Registration& without,
                              const std::vector<std::uint32_t>& rows) {
  EXPECT_EQ(with.status, without.status);
  EXPECT_EQ(with.T_target_source.matrix(), without.T_target_source.matrix());
  EXPECT_EQ(with.log10_false_poses, without.log10_false_poses);
  EXPECT_EQ(with.noise_bound, without.noise_bound);
  std::vector<std::uint32_t> inliers;
  for (const std::uint32_t row : without.inliers) inliers.push_back(rows[row]);
  EXPECT_EQ(with.inliers, inliers);
}

TEST(FarRows, ChangeNoBitOfWhatIsFoundWithoutThem) {
  std::uint64_t trial = 0;
  for (const double distance : kDistances) {
    for (const FarSide side : kSides) {
      for (const bool coincident : {false, true}) {
        for (const std::size_t far : {1U, 5U, 20U}) {
          ++trial;
          const Problem without = surveyed(trial);
          const Problem with = synth::with_far_rows(
              without, {.rows = far, .distance = distance, .side = side, .coincident = coincident, .trial = trial});
          const std::vector<std::uint32_t> rows = common_rows(with, without);
          ASSERT_EQ(rows.size(), without.size());
          const Correspondences all = with.correspondences();
          EXPECT_EQ(all.far_rows().size(), far) << distance;
          for (const char* solver : kSolvers) {
            SCOPED_TRACE(std::string(solver) + " trial " + std::to_string(trial));
            const SolverOptions options{.noise_bound = 0.05, .seed = trial};
            expect_same_but_for_rows(register_by_name(solver, all, options),
                                     register_by_name(solver, without.correspondences(), options), rows);
          }
        }
      }
    }
  }
}

TEST(FarRows, DoNotMoveTheEstimatedBound) {
  for (std::uint64_t trial = 0; trial < trials(40); ++trial) {
    const Problem without =
        synth::hard_problem({.correspondences = 200, .outlier_ratio = 0.4, .sigma = 0.01, .trial = trial});
    const Problem with = synth::with_far_rows(without, {.rows = 60, .distance = 1e9, .trial = trial});
    expect_same_but_for_rows(register_by_name("tcf", with.correspondences(), {.seed = trial}),
                             register_by_name("tcf", without.correspondences(), {.seed = trial}),
                             common_rows(with, without));
  }
}

TEST(Copies, NeitherAddToNorTakeFromTheEvidence) {
  for (std::uint64_t trial = 0; trial < trials(100); ++trial) {
    const synth::RepeatedTargetOptions once{.targets = 12, .frames = 1, .blunders = 0.2, .trial = trial};
    synth::RepeatedTargetOptions often = once;
    often.frames = 2 + trial % 5;
    const Problem single = synth::repeated_targets(once);
    const Problem copied = synth::repeated_targets(often);
    for (const char* solver : kSolvers) {
      SCOPED_TRACE(std::string(solver) + " trial " + std::to_string(trial));
      const Registration with = register_by_name(solver, copied.correspondences(), {.noise_bound = 0.05});
      const Registration without = register_by_name(solver, single.correspondences(), {.noise_bound = 0.05});
      EXPECT_EQ(with.status, without.status);
      EXPECT_NEAR(with.log10_false_poses, without.log10_false_poses, 2.5);  // rows in another order
      EXPECT_EQ(with.inliers.size(), often.frames * without.inliers.size());
    }
  }
}

/// Forty rows on a line among eighty others, or none; the noise of the sources too looks like a width of the line.
TEST(EverySolver, HasNoPoseThatTurnsAboutALine) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, 0.01);
  for (std::uint64_t trial = 0; trial < trials(40); ++trial) {
    const bool is_noisy = trial % 2 == 0;
    Problem problem = synth::hard_problem({.correspondences = trial % 4 < 2 ? 120U : 40U,
                                           .outlier_ratio = trial % 4 < 2 ? 2.0 / 3.0 : 0.0,
                                           .sigma = 0.01,
                                           .half_extent = 5.0,
                                           .trial = trial,
                                           .scene = synth::Scene::linear,
                                           .thickness = 0.0});
    if (is_noisy) {
      for (double& x : problem.source) x += noise(random);
    }
    for (const char* solver : kSolvers) {
      SCOPED_TRACE(std::string(solver) + " trial " + std::to_string(trial));
      const Registration result =
          register_by_name(solver, problem.correspondences(), {.noise_bound = is_noisy ? 0.056 : 0.04});
      EXPECT_FALSE(result.has_pose()) << result.inliers.size() << " inliers";
    }
  }
}

TEST(TinyBounds, AreRaisedToWhatTheFrameResolvesAndSaidSo) {
  for (std::uint64_t trial = 0; trial < trials(60); ++trial) {
    const Problem problem = synth::hard_problem(
        {.correspondences = 300, .outlier_ratio = 0.3, .sigma = 0.0, .half_extent = 50.0, .trial = trial});
    const Correspondences rows = problem.correspondences();
    for (const char* solver : kSolvers) {
      SCOPED_TRACE(std::string(solver) + " trial " + std::to_string(trial));
      const double asked = std::pow(10.0, -6.0 - static_cast<double>(trial % 20));
      const Registration result = register_by_name(solver, rows, {.noise_bound = asked});
      EXPECT_EQ(result.noise_bound_asked, asked);
      EXPECT_EQ(result.noise_bound, rows.resolution());
      EXPECT_LT(result.noise_bound, 1e-5 * 50.0);
      EXPECT_EQ(result.status, Status::success);
      EXPECT_GE(result.inliers.size(), 205U);  // of 210
      EXPECT_TRUE(is_right(problem, result, result.noise_bound));
    }
  }
}

TEST(EverySolver, HasSupportersForItsPoseAndWordsForPeople) {
  // Bounds from absurd to absurd on problems with all the nuisances at once: no message, no pose without support.
  for (std::uint64_t trial = 0; trial < trials(200); ++trial) {
    Problem problem = synth::hard_problem({.correspondences = 4 + trial % 30,
                                           .outlier_ratio = 0.5,
                                           .sigma = 0.01,
                                           .half_extent = 10.0,
                                           .trial = trial,
                                           .quantum = trial % 4 == 0 ? 0.5 : 0.0});
    problem = synth::with_far_rows(problem, {.rows = trial % 3, .distance = kDistances[trial % 5], .trial = trial});
    problem = synth::with_rows_without_depth(problem, trial % 7, 1, trial);
    const double bound = std::pow(10.0, static_cast<double>(trial % 17) - 11.0);
    for (const char* solver : {"tcf", "tcf-published", "ransac", "sc2_pcr", "turboreg", "pcr99", "teaser", "mac"}) {
      SCOPED_TRACE(std::string(solver) + " trial " + std::to_string(trial));
      Registration result;
      ASSERT_NO_THROW(result = register_by_name(solver, problem.correspondences(), {.noise_bound = bound}));
      EXPECT_TRUE(result.has_pose() ? result.inliers.size() >= 3 : result.inliers.empty());
      EXPECT_TRUE(result.T_target_source.matrix().allFinite());
    }
  }
}

}  // namespace
}  // namespace consimd::test
