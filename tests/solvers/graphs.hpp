// Random graphs, and cliques by brute force.
#pragma once

#include <consimd/solvers/bit_graph.hpp>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace consimd::test {

using Vertices = std::vector<std::uint32_t>;

/// Each pair is adjacent with the given probability.
inline BitGraph random_graph(std::size_t size, double density, std::uint32_t seed) {
  BitGraph graph(size);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = i + 1; j < size; ++j) {
      if (static_cast<double>(random()) < density * 0x1p32) graph.connect(i, j);
    }
  }
  return graph;
}

/// A random graph in which `members` of the vertices form a clique.
inline BitGraph graph_with_clique(std::size_t size, double density, std::size_t members, std::uint32_t seed) {
  BitGraph graph = random_graph(size, density, seed);
  Vertices order(size);
  for (std::uint32_t v = 0; v < size; ++v) order[v] = v;
  std::mt19937 random(seed + 1);
  for (std::size_t i = size; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  for (std::size_t i = 0; i < members; ++i) {
    for (std::size_t j = 0; j < i; ++j) graph.connect(order[i], order[j]);
  }
  return graph;
}

inline bool is_clique(const GraphView& graph, const Vertices& vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!graph.adjacent(vertices[i], vertices[j])) return false;
    }
  }
  return true;
}

namespace brute_force {

inline void extend(const GraphView& graph, const Vertices& clique, const Vertices& candidates, const Vertices& excluded,
                   std::vector<Vertices>& found) {
  if (candidates.empty() && excluded.empty()) found.push_back(clique);
  Vertices left = candidates;
  Vertices out = excluded;
  while (!left.empty()) {
    const std::uint32_t v = left.back();
    left.pop_back();
    Vertices next = clique;
    next.push_back(v);
    const auto neighbours = [&](const Vertices& of) {
      Vertices adjacent;
      std::ranges::copy_if(of, std::back_inserter(adjacent), [&](std::uint32_t u) { return graph.adjacent(u, v); });
      return adjacent;
    };
    extend(graph, next, neighbours(left), neighbours(out), found);
    out.push_back(v);
  }
}

/// By Bron and Kerbosch's first version, without a pivot; each ascending, all in lexicographic order.
inline std::vector<Vertices> maximal_cliques(const GraphView& graph) {
  Vertices all(graph.size());
  for (std::uint32_t v = 0; v < all.size(); ++v) all[v] = v;
  std::vector<Vertices> found;
  if (!all.empty()) extend(graph, {}, all, {}, found);
  for (Vertices& clique : found) std::ranges::sort(clique);
  std::ranges::sort(found);
  return found;
}

inline std::size_t clique_number(const GraphView& graph) {
  std::size_t largest = 0;
  for (const Vertices& clique : brute_force::maximal_cliques(graph)) largest = std::max(largest, clique.size());
  return largest;
}

}  // namespace brute_force
}  // namespace consimd::test
