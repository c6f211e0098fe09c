// All maximal cliques.
#include <consimd/solvers/maximal_cliques.hpp>

#ifdef CONSIMD_HAVE_IGRAPH
#include <igraph/igraph.h>
#endif

#include <tuple>
#include <vector>

#include "graphs.hpp"
#include "problems.hpp"

namespace consimd::test {
namespace {

std::vector<Vertices> sorted(std::vector<Vertices> cliques) {
  std::ranges::sort(cliques);
  return cliques;
}

class MaximalCliquesOfRandomGraphs : public ::testing::TestWithParam<std::tuple<std::size_t, double>> {};
INSTANTIATE_TEST_SUITE_P(SizesAndDensities, MaximalCliquesOfRandomGraphs,
                         ::testing::Combine(::testing::Values(0, 1, 2, 3, 8, 15, 40, 70),
                                            ::testing::Values(0.0, 0.1, 0.3, 0.5, 0.8, 1.0)));

TEST_P(MaximalCliquesOfRandomGraphs, AreThoseOfBruteForce) {
  const auto [size, density] = GetParam();
  if (static_cast<double>(size) * density > 21.0) GTEST_SKIP() << "brute force would take long";
  for (std::uint32_t seed = 0; seed < trials(20); ++seed) {
    const BitGraph graph = random_graph(size, density, seed);
    const std::vector<Vertices> expected = brute_force::maximal_cliques(graph);
    const MaximalCliques found = maximal_cliques(graph);
    EXPECT_EQ(sorted(found.cliques), expected);
    EXPECT_TRUE(found.cut_short.empty());
    std::vector<Vertices> large = expected;
    std::erase_if(large, [](const Vertices& clique) { return clique.size() < 3; });
    EXPECT_EQ(sorted(maximal_cliques(graph, {.min_size = 3}).cliques), large);
  }
}

TEST(MaximalCliques, OfTheMoonMoserGraphAreThreeToTheThird) {
  // Vertices are adjacent unless they are of the same three: the most cliques a graph can have.
  BitGraph graph(24);
  for (std::size_t i = 0; i < 24; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (i / 3 != j / 3) graph.connect(i, j);
    }
  }
  EXPECT_EQ(maximal_cliques(graph).cliques.size(), 6561u);
}

#ifdef CONSIMD_HAVE_IGRAPH
std::vector<Vertices> igraph_maximal_cliques_of(const GraphView& graph) {
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
  igraph_vector_int_list_t lists;
  igraph_vector_int_list_init(&lists, 0);
  igraph_maximal_cliques(&other, &lists, 3, 0);
  std::vector<Vertices> cliques;
  for (igraph_integer_t c = 0; c < igraph_vector_int_list_size(&lists); ++c) {
    const igraph_vector_int_t* list = igraph_vector_int_list_get_ptr(&lists, c);
    Vertices& clique = cliques.emplace_back();
    for (igraph_integer_t i = 0; i < igraph_vector_int_size(list); ++i) {
      clique.push_back(static_cast<std::uint32_t>(VECTOR(*list)[i]));
    }
    std::ranges::sort(clique);
  }
  igraph_vector_int_list_destroy(&lists);
  igraph_vector_int_destroy(&edges);
  igraph_destroy(&other);
  return cliques;
}

TEST(MaximalCliques, AreThoseOfIgraph) {
  for (const auto& [size, density] :
       {std::pair(500U, 0.05), std::pair(200U, 0.2), std::pair(100U, 0.4), std::pair(60U, 0.6), std::pair(40U, 0.8)}) {
    for (std::uint32_t seed = 0; seed < trials(5); ++seed) {
      SCOPED_TRACE(::testing::Message() << size << " vertices, density " << density << ", seed " << seed);
      const BitGraph graph = random_graph(size, density, seed);
      EXPECT_EQ(sorted(maximal_cliques(graph, {.min_size = 3}).cliques), sorted(igraph_maximal_cliques_of(graph)));
    }
  }
}
#endif

TEST(MaximalCliques, BudgetsAreKeptAndReported) {
  const BitGraph graph = random_graph(200, 0.5, 3);
  const MaximalCliques all = maximal_cliques(graph);
  const std::vector<Vertices> known = sorted(all.cliques);
  for (const std::uint64_t budget : {0U, 199U, 200U, 2000U, 10'000U}) {
    const MaximalCliques by_nodes = maximal_cliques(graph, {.max_nodes = budget});
    EXPECT_LE(by_nodes.nodes, budget);
    const MaximalCliques by_cliques = maximal_cliques(graph, {.max_cliques = budget});
    EXPECT_LE(by_cliques.cliques.size(), budget);
    for (const MaximalCliques& part : {by_nodes, by_cliques}) {
      EXPECT_FALSE(part.cut_short.empty());
      for (const Vertices& clique : part.cliques) EXPECT_TRUE(std::ranges::binary_search(known, clique));
    }
  }
}

}  // namespace
}  // namespace consimd::test
