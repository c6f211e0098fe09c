// What of a graph needs no search on the way to its maximum clique.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include <consimd/solvers/bit_graph.hpp>

namespace consimd::detail {

/// A graph that shrinks while cliques are found: vertices that no larger clique can hold go, vertices that a largest
/// one of the rest holds for sure are set aside.
class ReducedGraph {
 public:
  /// Keeps the view, whose owner must live as long. Cliques of up to `larger_than` vertices are of no interest.
  ReducedGraph(const GraphView& graph, std::uint32_t larger_than);

  /// Offers a clique of what is left; with the vertices set aside it is one of the whole graph.
  void offer(const std::vector<std::uint32_t>& clique);
  /// The largest clique known, vertices of the whole graph.
  [[nodiscard]] const std::vector<std::uint32_t>& best() const noexcept { return best_; }
  /// Vertices that a clique of what is left must have to make a larger one.
  [[nodiscard]] std::uint32_t wanted() const noexcept {
    return static_cast<std::uint32_t>(std::max(best_.size(), larger_than_) + 1 - settled_.size());
  }

  /// Vertices of what is left that no clique of `wanted` vertices can hold: `reduce` drops them.
  void rule_out(const std::vector<std::uint32_t>& vertices) {
    for (const std::uint32_t v : vertices) numbers_.core[v] = 0;
    ruled_out_ = ruled_out_ || !vertices.empty();
  }

  /// Drops and sets aside what can be, until nothing changes. Renumbers the vertices: the one peeled last comes first.
  void reduce();

  [[nodiscard]] GraphView rest() const noexcept { return original_ ? view_ : GraphView(graph_); }
  /// Core numbers in what is left; after `reduce` descending.
  [[nodiscard]] const std::vector<std::uint32_t>& core() const noexcept { return numbers_.core; }

 private:
  void settle(std::vector<std::uint32_t>& kept);
  void keep(const std::vector<std::uint32_t>& kept);

  GraphView view_;  // the whole graph, until something is left out
  bool original_ = true;
  bool ruled_out_ = false;
  BitGraph graph_;
  std::vector<std::uint32_t> names_;  // of the vertices in the whole graph
  CoreNumbers numbers_;
  std::vector<std::uint32_t> settled_;  // set aside; vertices of the whole graph
  std::size_t larger_than_;
  std::vector<std::uint32_t> best_;
};

}  // namespace consimd::detail
