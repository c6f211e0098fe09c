// All sets of rows that agree pairwise, against what graphs tell of them.
#include <oneapi/tbb/task_arena.h>
#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/solvers/bit_graph.hpp>
#include <consimd/solvers/maximal_cliques.hpp>
#include <consimd/synth/noise_study.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "problems.hpp"
#include "search/sparse_sets.hpp"

namespace consimd::test {
namespace {

using Sets = std::vector<std::vector<std::uint32_t>>;

constexpr std::size_t kLargestBudget = std::numeric_limits<std::size_t>::max();

// Rows in a cube of 200 m, a few of which are true, and the bound to which pairs of them agree.
Problem sparse_problem(std::size_t rows, double sigma, std::uint64_t trial) {
  return synth::noise_study_problem({.correspondences = rows,
                                     .outlier_ratio = 1.0 - 7.0 / static_cast<double>(rows),
                                     .sigma = sigma,
                                     .trial = trial});
}

Sets cliques(const Correspondences& rows, double bound, std::uint32_t least) {
  ConsistencyMatrix matrix;
  matrix.compute(rows.view(), bound);
  return maximal_cliques(matrix, {.min_size = least}).cliques;
}

TEST(SparseSets, HoldTheLargestCliquesAndNothingElse) {
  for (const std::size_t rows : {7U, 63U, 64U, 65U, 200U, 700U}) {
    for (const double sigma : {0.1, 0.5, 2.0}) {
      for (std::uint64_t trial = 0; trial < 4; ++trial) {
        const Problem problem = sparse_problem(rows, sigma, trial);
        const Correspondences correspondences = problem.correspondences();
        const double bound = 2.0 * synth::noise_study_bound(sigma);
        for (const std::uint32_t least : {3U, 5U, 7U}) {
          const detail::SparseSets found = detail::sparse_sets(correspondences, bound, least, {});
          ASSERT_TRUE(found.all);
          ASSERT_GE(found.least, least);
          const Sets all = cliques(correspondences, bound, found.least);
          std::size_t largest = 0;
          for (const auto& clique : all) largest = std::max(largest, clique.size());
          ASSERT_EQ(found.sets.empty() ? 0 : found.sets.front().size(), largest) << rows << " rows";
          ConsistencyMatrix matrix;
          matrix.compute(correspondences.view(), bound);
          const GraphView graph = matrix;
          for (const auto& set : found.sets) {
            ASSERT_GE(set.size(), found.least);
            ASSERT_TRUE(std::ranges::is_sorted(set));
            for (const std::uint32_t i : set) {
              for (const std::uint32_t j : set) ASSERT_TRUE(graph.adjacent(i, j));
            }
          }
          // A maximal clique is one of the sets, or shares a row with one that is as large.
          for (const auto& clique : all) {
            ASSERT_TRUE(std::ranges::any_of(found.sets, [&](const auto& set) {
              return set.size() >= clique.size() && std::ranges::any_of(clique, [&](std::uint32_t row) {
                       return std::ranges::binary_search(set, row);
                     });
            }));
          }
          ASSERT_TRUE(
              std::ranges::is_sorted(found.sets, [](const auto& a, const auto& b) { return a.size() > b.size(); }));
        }
      }
    }
  }
}

TEST(SparseSets, AreTheSameForAnyNumberOfThreads) {
  const Problem problem = sparse_problem(900, 0.5, 0);
  const Correspondences correspondences = problem.correspondences();
  const double bound = 2.0 * synth::noise_study_bound(0.5);
  const Sets expected = detail::sparse_sets(correspondences, bound, 4, {}).sets;
  ASSERT_FALSE(expected.empty());
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    EXPECT_EQ(arena.execute([&] { return detail::sparse_sets(correspondences, bound, 4, {}).sets; }), expected);
  }
}

TEST(SparseSets, EndWhereTheCallerWantsThemTo) {
  const Problem problem = sparse_problem(200, 0.5, 0);
  const std::atomic<bool> requested = true;
  const detail::SparseSets found = detail::sparse_sets(problem.correspondences(), 3.0, 3, {.requested = &requested});
  EXPECT_FALSE(found.all);
  EXPECT_TRUE(found.sets.empty());
}

TEST(SparseSets, AreGivenUpWhereThereAreTooMany) {
  // Most pairs agree to within half of the cube.
  const Problem problem = sparse_problem(300, 0.5, 0);
  const detail::SparseSets found = detail::sparse_sets(problem.correspondences(), 100.0, 3, {});
  EXPECT_FALSE(found.all);
  EXPECT_TRUE(found.sets.empty());
}

TEST(SparseSets, TakeTheTimeOfSeedsWhereFewPairsAgree) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  EXPECT_LT(detail::seeds_for_all_sets(3000, 0.03, kLargestBudget), 1500.0);
  EXPECT_EQ(detail::seeds_for_all_sets(3000, 0.1, kLargestBudget), kNever);
  EXPECT_EQ(detail::seeds_for_all_sets(3000, 0.03, 1U << 20U), kNever);  // the matrix takes 1.1 MB
  EXPECT_EQ(detail::seeds_for_all_sets(20'000, 0.02, kLargestBudget), kNever);
}

TEST(SparseSets, ByChanceHaveTheRowsThatRandomGraphsHave) {
  EXPECT_EQ(detail::largest_by_chance(0, 0.5), 0U);
  EXPECT_EQ(detail::largest_by_chance(10, 0.0), 1U);
  EXPECT_EQ(detail::largest_by_chance(10, 1.0), 10U);
  // C(3000, 5) 0.03^10 = 1.2 and C(3000, 6) 0.03^15 = 1e-5.
  EXPECT_EQ(detail::largest_by_chance(3000, 0.03), 5U);
}

}  // namespace
}  // namespace consimd::test
