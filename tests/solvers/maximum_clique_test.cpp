// Cores and the maximum clique.
#include <consimd/solvers/bit_graph.hpp>
#include <consimd/solvers/maximum_clique.hpp>
#include <consimd/synth/noise_study.hpp>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#ifdef CONSIMD_HAVE_IGRAPH
#include <igraph/igraph.h>
#endif

#include <stdexcept>
#include <tuple>
#include <vector>

#include "graphs.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

TEST(BitGraph, SubgraphKeepsTheEdgesAndTheGivenOrder) {
  const BitGraph graph = random_graph(150, 0.3, 1);
  const GraphView view = graph;
  const Vertices chosen = random_order(150, 2);
  for (const std::size_t size : {0U, 1U, 2U, 63U, 64U, 65U, 150U}) {
    BitGraph sub;
    sub.assign_subgraph(graph, std::span(chosen).first(size));
    ASSERT_EQ(sub.size(), size);
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < size; ++j) {
        EXPECT_EQ(GraphView(sub).adjacent(i, j), i != j && view.adjacent(chosen[i], chosen[j]));
      }
    }
  }
}

TEST(BitGraph, BadVerticesAreRejected) {
  BitGraph graph(3);
  EXPECT_THROW(graph.connect(0, 3), std::out_of_range);
  EXPECT_THROW(graph.connect(3, 0), std::out_of_range);
  EXPECT_THROW(graph.connect(1, 1), std::invalid_argument);
  BitGraph sub;
  EXPECT_THROW(sub.assign_subgraph(graph, Vertices{0, 3}), std::out_of_range);
}

/// Core numbers by the definition: vertices of fewer than k neighbours are dropped until none is left.
Vertices slow_core_numbers(const GraphView& graph) {
  Vertices core(graph.size(), 0);
  for (std::uint32_t k = 1; k < graph.size(); ++k) {
    std::vector<bool> alive(graph.size(), true);
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = 0; v < graph.size(); ++v) {
        if (!alive[v]) continue;
        std::uint32_t degree = 0;
        for (std::size_t u = 0; u < graph.size(); ++u) {
          if (u != v && alive[u] && graph.adjacent(u, v)) ++degree;
        }
        if (degree < k) {
          alive[v] = false;
          changed = true;
        }
      }
    }
    for (std::size_t v = 0; v < graph.size(); ++v) {
      if (alive[v]) core[v] = k;
    }
  }
  return core;
}

class RandomGraphs : public ::testing::TestWithParam<std::tuple<std::size_t, double>> {};
INSTANTIATE_TEST_SUITE_P(SizesAndDensities, RandomGraphs,
                         ::testing::Combine(::testing::Values(0, 1, 2, 3, 7, 20, 40, 70),
                                            ::testing::Values(0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)));

TEST_P(RandomGraphs, CoreNumbersFollowTheDefinition) {
  const auto [size, density] = GetParam();
  const BitGraph graph = random_graph(size, density, 3);
  const CoreNumbers numbers = core_numbers(graph);
  EXPECT_EQ(numbers.core, slow_core_numbers(graph));
  EXPECT_TRUE(std::ranges::is_sorted(numbers.order, {}, [&](std::uint32_t v) { return numbers.core[v]; }));
  // No vertex has more neighbours after it in a degeneracy order than its core number.
  for (std::size_t i = 0; i < numbers.order.size(); ++i) {
    std::uint32_t later = 0;
    for (std::size_t j = i + 1; j < size; ++j) {
      if (GraphView(graph).adjacent(numbers.order[i], numbers.order[j])) ++later;
    }
    EXPECT_LE(later, numbers.core[numbers.order[i]]);
  }
  const Vertices largest = maximum_core(graph);
  EXPECT_EQ(largest.empty(), size == 0);
  for (const std::uint32_t v : largest) EXPECT_EQ(numbers.core[v], std::ranges::max(numbers.core));
}

TEST_P(RandomGraphs, MaximumCliqueIsThatOfBruteForce) {
  const auto [size, density] = GetParam();
  if (static_cast<double>(size) * density > 25.0 || (size > 15 && density > 0.8))
    GTEST_SKIP() << "brute force would take long";
  for (std::uint32_t seed = 0; seed < trials(20); ++seed) {
    const BitGraph graph = random_graph(size, density, seed);
    const MaximumClique clique = maximum_clique(graph);
    EXPECT_TRUE(clique.proven);
    EXPECT_TRUE(is_clique(graph, clique.members));
    EXPECT_TRUE(std::ranges::is_sorted(clique.members, std::ranges::less_equal{}));
    EXPECT_EQ(clique.members.size(), brute_force::clique_number(graph)) << "seed " << seed;
  }
}

#ifdef CONSIMD_HAVE_IGRAPH
igraph_integer_t igraph_clique_number_of(const GraphView& graph) {
  igraph_t other;
  igraph_empty(&other, static_cast<igraph_integer_t>(graph.size()), IGRAPH_UNDIRECTED);
  igraph_vector_int_t edges;
  igraph_vector_int_init(&edges, 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!graph.adjacent(i, j)) continue;
      igraph_vector_int_push_back(&edges, static_cast<igraph_integer_t>(i));
      igraph_vector_int_push_back(&edges, static_cast<igraph_integer_t>(j));
    }
  }
  igraph_add_edges(&other, &edges, nullptr);
  igraph_integer_t number = 0;
  igraph_clique_number(&other, &number);
  igraph_vector_int_destroy(&edges);
  igraph_destroy(&other);
  return number;
}

TEST(MaximumClique, IsAsLargeAsIgraphs) {
  for (const auto& [size, density] :
       {std::pair(300U, 0.1), std::pair(120U, 0.3), std::pair(80U, 0.5), std::pair(50U, 0.7), std::pair(35U, 0.9)}) {
    for (std::uint32_t seed = 0; seed < trials(5); ++seed) {
      SCOPED_TRACE(::testing::Message() << size << " vertices, density " << density << ", seed " << seed);
      const BitGraph graph = random_graph(size, density, seed);
      const MaximumClique clique = maximum_clique(graph);
      EXPECT_TRUE(clique.proven);
      EXPECT_TRUE(is_clique(graph, clique.members));
      EXPECT_EQ(static_cast<igraph_integer_t>(clique.members.size()), igraph_clique_number_of(graph));
    }
  }
}
#endif

class PlantedClique : public ::testing::TestWithParam<std::tuple<double, std::size_t>> {};
INSTANTIATE_TEST_SUITE_P(DensitiesAndMembers, PlantedClique,
                         ::testing::Combine(::testing::Values(0.02, 0.1, 0.2), ::testing::Values(30, 100, 500, 1000)));

TEST_P(PlantedClique, IsFoundAndProven) {
  const auto [density, members] = GetParam();
  const BitGraph graph = graph_with_clique(1000, density, members, 7);
  const MaximumClique clique = maximum_clique(graph);
  EXPECT_TRUE(clique.proven);
  EXPECT_GE(clique.members.size(), members);
  EXPECT_LE(clique.members.size(), members + 3);
  EXPECT_TRUE(is_clique(graph, clique.members));
}

TEST(MaximumClique, OfANearlyCompleteGraphNeedsNoSearch) {
  // Of 900 vertices, 200 miss one, two or three others along paths of four: half of them can stay.
  BitGraph complete = graph_with_clique(900, 0.0, 900, 0);
  BitGraph graph(900);
  for (std::size_t i = 0; i < 900; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool path = i < 200 && j + 1 == i && i % 4 != 0;
      if (GraphView(complete).adjacent(i, j) && !path) graph.connect(i, j);
    }
  }
  const MaximumClique clique = maximum_clique(graph);
  EXPECT_TRUE(clique.proven);
  EXPECT_EQ(clique.nodes, 0u);
  EXPECT_EQ(clique.members.size(), 800u);
  EXPECT_TRUE(is_clique(graph, clique.members));
}

TEST(MaximumClique, BudgetIsKeptAndReported) {
  const BitGraph graph = random_graph(400, 0.6, 5);
  std::size_t former = 0;
  for (const std::uint64_t max_nodes : {0U, 1U, 31U, 1000U, 100'000U}) {
    const MaximumClique clique = maximum_clique(graph, {.max_nodes = max_nodes});
    EXPECT_LE(clique.nodes, max_nodes);
    EXPECT_FALSE(clique.proven) << max_nodes;
    EXPECT_TRUE(is_clique(graph, clique.members));
    EXPECT_GE(clique.members.size(), 12u);
    EXPECT_GE(clique.members.size(), former);
    former = clique.members.size();
  }
}

TEST(MaximumClique, BudgetOfWordsIsKeptAndReported) {
  const BitGraph graph = random_graph(700, 0.6, 5);
  const MaximumClique unlimited = maximum_clique(graph, {.max_nodes = 2000});
  std::size_t former = 0;
  for (const std::uint64_t max_work : {std::uint64_t{1}, unlimited.work / 100, unlimited.work / 4, unlimited.work}) {
    const MaximumClique clique = maximum_clique(graph, {.max_nodes = 2000, .max_work = max_work});
    EXPECT_FALSE(clique.proven);
    EXPECT_TRUE(is_clique(graph, clique.members));
    EXPECT_GE(clique.members.size(), std::max<std::size_t>(former, 5));
    EXPECT_LE(clique.work, max_work + unlimited.work / 10) << max_work;
    former = clique.members.size();
  }
}

TEST(MaximumClique, OfAConsistencyMatrixHoldsTheInliers) {
  const Problem problem = synth::noise_study_problem({.correspondences = 1000, .outlier_ratio = 0.9, .sigma = 1.0});
  ConsistencyMatrix matrix;
  matrix.compute(problem.correspondences().view(), 6.0);
  const MaximumClique clique = maximum_clique(matrix);
  EXPECT_TRUE(clique.proven);
  std::size_t inliers = 0;
  for (const std::uint32_t k : clique.members) inliers += problem.is_inlier[k];
  EXPECT_GE(inliers, 95u);
  EXPECT_LE(clique.members.size(), inliers + 3);
}

TEST(MaximumClique, IsTheSameForAnyNumberOfThreadsAndEveryInstructionSet) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Isa before = active_isa();
  for (const auto& [max_nodes, max_work] :
       {std::pair(200U, 1'000'000'000U), std::pair(1'000'000U, 1'000'000'000U), std::pair(1'000'000U, 1'000'000U)}) {
    const BitGraph graph = random_graph(300, 0.4, 9);
    const MaximumCliqueOptions options{.max_nodes = max_nodes, .max_work = max_work};
    const MaximumClique expected = maximum_clique(graph, options);
    const auto expect_same = [&] {
      const MaximumClique clique = maximum_clique(graph, options);
      EXPECT_EQ(clique.members, expected.members);
      EXPECT_EQ(clique.nodes, expected.nodes);
      EXPECT_EQ(clique.work, expected.work);
      EXPECT_EQ(clique.proven, expected.proven);
    };
    for (const int threads : {1, 2, 4}) tbb::task_arena(threads).execute(expect_same);
    for (const Isa isa : supported_isas()) {
      set_active_isa(isa);
      expect_same();
    }
    set_active_isa(before);
  }
}

}  // namespace
}  // namespace consimd::test
