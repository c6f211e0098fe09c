// The maximal cliques around one vertex.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <consimd/solvers/bit_graph.hpp>

#include "bits/bit_rows.hpp"

namespace consimd::detail {

/// Bron-Kerbosch with a pivot in the neighbourhood of a vertex. Holds the memory of the search, kept between calls.
class CliqueEnumeration {
 public:
  struct Limits {
    std::uint32_t min_size = 1;
    std::uint64_t max_cliques = 0;
    std::uint64_t max_nodes = 0;
  };

  /// Calls visit(clique) for the maximal cliques of the graph of which `vertex` comes first in an order of the
  /// vertices; rank: the place of each in it. The clique is a span of positions in `vertices`.
  template <typename Visit>
  void run(const GraphView& graph, std::span<const std::uint32_t> rank, std::uint32_t vertex, const Limits& limits,
           const Visit& visit) {
    if (!start(graph, rank, vertex, limits)) return;
    expand(0, visit);
  }

  /// The neighbours of the vertex, those with most common neighbours first, and at last the vertex itself.
  [[nodiscard]] const std::vector<std::uint32_t>& vertices() const noexcept { return vertices_; }
  /// Whether the search ended within its limits.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  [[nodiscard]] std::uint64_t nodes() const noexcept { return nodes_; }

 private:
  /// Vertices that may still join, and those that would but belong to cliques visited before.
  struct Level {
    std::vector<std::uint64_t> candidates;
    std::vector<std::uint64_t> excluded;
    std::vector<std::uint64_t> branches;
  };

  bool start(const GraphView& graph, std::span<const std::uint32_t> rank, std::uint32_t vertex, const Limits& limits);
  /// Fills the branches of a level: all candidates but the neighbours of the pivot.
  void choose_branches(Level& level);
  Level& level_at(std::size_t depth);

  template <typename Visit>
  void expand(std::size_t depth, const Visit& visit) {
    if (nodes_ == limits_.max_nodes) {
      complete_ = false;
      return;
    }
    ++nodes_;
    Level& level = level_at(depth);
    if (is_empty(level.candidates)) {
      if (!is_empty(level.excluded) || clique_.size() < limits_.min_size) return;
      if (cliques_ == limits_.max_cliques) {
        complete_ = false;
        return;
      }
      ++cliques_;
      visit(std::span<const std::uint32_t>(clique_));
      return;
    }
    if (clique_.size() + popcount(level.candidates) < limits_.min_size) return;
    choose_branches(level);
    level_at(depth + 1);  // may move the levels
    for (std::size_t w = 0; w < graph_.words() && complete_; ++w) {
      for (std::uint64_t left = levels_[depth].branches[w]; left != 0 && complete_; left &= left - 1) {
        const auto v = static_cast<std::uint32_t>(w * kBlock + static_cast<std::size_t>(std::countr_zero(left)));
        Level& from = levels_[depth];
        Level& to = levels_[depth + 1];
        const std::span<const std::uint64_t> row = GraphView(graph_).row(v);
        intersect(from.candidates, row, to.candidates);
        intersect(from.excluded, row, to.excluded);
        clique_.push_back(v);
        expand(depth + 1, visit);
        clique_.pop_back();
        clear_bit(levels_[depth].candidates, v);
        set_bit(levels_[depth].excluded, v);
      }
    }
  }

  Limits limits_;
  std::uint64_t nodes_ = 0;
  std::uint64_t cliques_ = 0;
  bool complete_ = true;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> neighbours_;  // common neighbours, vertex
  std::vector<std::uint32_t> vertices_;
  BitGraph graph_;  // of the neighbours
  std::vector<std::uint32_t> clique_;
  std::vector<Level> levels_;
};

}  // namespace consimd::detail
