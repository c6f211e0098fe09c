// Branch and bound for the maximum clique of a small graph.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/solvers/bit_graph.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace consimd::detail {

/// What combining a row costs beside its words, in words.
inline constexpr std::uint64_t kRowWork = 32;

/// Holds the memory of the search, kept between calls.
class CliqueBranching {
 public:
  /// A clique of at least `wanted` > 0 vertices, the largest, or none. Stops after `max_nodes` nodes or
  /// `max_work` of work (see MaximumCliqueOptions), or when the condition is met. Vertices of high degree should come
  /// first.
  void run(const GraphView& graph, std::uint32_t wanted, std::uint64_t max_nodes, std::uint64_t max_work,
           const StopCondition& stop);

  /// Empty: none that large was found.
  [[nodiscard]] const std::vector<std::uint32_t>& clique() const noexcept { return clique_; }
  /// Whether the search ended by itself: `clique` is what was asked for.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  [[nodiscard]] std::uint64_t nodes() const noexcept { return nodes_; }
  [[nodiscard]] std::uint64_t work() const noexcept { return work_; }

 private:
  struct Branch {
    std::uint32_t vertex;
    std::uint32_t colours;  // that it and the vertices coloured before it take: no clique among them is larger
  };

  void expand(std::size_t depth);
  void colour(std::span<const std::uint64_t> candidates, std::uint32_t least);
  std::span<std::uint64_t> candidates_at(std::size_t depth);

  const GraphView* graph_ = nullptr;
  std::uint32_t wanted_ = 0;
  std::uint64_t max_nodes_ = 0;
  std::uint64_t max_work_ = 0;
  StopCondition stop_;
  std::uint64_t nodes_ = 0;
  std::uint64_t work_ = 0;
  bool complete_ = true;
  std::vector<std::uint32_t> clique_;
  std::vector<std::uint32_t> current_;
  std::vector<std::vector<std::uint64_t>> candidates_;  // by depth
  std::vector<Branch> branches_;                        // of all open nodes
  std::vector<std::uint64_t> uncoloured_;
  std::vector<std::uint64_t> colour_class_;
};

}  // namespace consimd::detail
