#include "cliques/clique_reduction.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bits/bit_rows.hpp"

namespace consimd::detail {

ReducedGraph::ReducedGraph(const GraphView& graph, std::uint32_t larger_than)
    : view_(graph), names_(graph.size()), numbers_(core_numbers(graph)), larger_than_(larger_than) {
  std::iota(names_.begin(), names_.end(), 0U);
}

void ReducedGraph::offer(const std::vector<std::uint32_t>& clique) {
  if (clique.size() < wanted()) return;
  best_ = settled_;
  for (const std::uint32_t v : clique) best_.push_back(names_[v]);
}

void ReducedGraph::reduce() {
  std::vector<std::uint32_t> kept;
  while (true) {
    kept.clear();
    for (std::size_t p = numbers_.order.size(); p-- > 0;) {
      const std::uint32_t v = numbers_.order[p];
      if (numbers_.core[v] + 1 >= wanted()) kept.push_back(v);
    }
    const std::size_t core_size = kept.size();
    settle(kept);
    if (settled_.size() > best_.size()) best_ = settled_;
    const bool unchanged = kept.size() == names_.size() && std::ranges::is_sorted(kept);
    if (unchanged && !original_) return;
    keep(kept);
    // Otherwise what is left is a core, which keeps its core numbers and its order.
    if (kept.size() < core_size || ruled_out_) numbers_ = core_numbers(graph_);
    ruled_out_ = false;
  }
}

// A vertex of `kept` that is adjacent to all others belongs to a largest clique. So does one that misses a single
// other, since it could take that one's place.
void ReducedGraph::settle(std::vector<std::uint32_t>& kept) {
  const GraphView graph = rest();
  std::vector<std::uint64_t> alive(graph.words(), 0);
  for (const std::uint32_t v : kept) set_bit(alive, v);
  std::vector<std::uint32_t> missing(graph.size());  // others that are not adjacent
  std::vector<std::uint32_t> ready;
  for (const std::uint32_t v : kept) {
    const std::uint32_t adjacent = and_popcount(graph.row(v), alive) - (graph.adjacent(v, v) ? 1U : 0U);
    missing[v] = static_cast<std::uint32_t>(kept.size()) - 1 - adjacent;
    if (missing[v] <= 1) ready.push_back(v);
  }
  const auto for_each_missing = [&](std::uint32_t v, const auto& visit) {
    const std::span<const std::uint64_t> row = graph.row(v);
    for (std::size_t w = 0; w < alive.size(); ++w) for_each_in_word(alive[w] & ~row[w], w, visit);
  };
  for (std::size_t i = 0; i < ready.size(); ++i) {
    const std::uint32_t taken = ready[i];
    if (!test_bit(alive, taken)) continue;
    settled_.push_back(names_[taken]);
    clear_bit(alive, taken);
    std::uint32_t dropped = taken;
    for_each_missing(taken, [&](std::uint32_t u) { dropped = u; });
    if (dropped == taken) continue;
    clear_bit(alive, dropped);
    for_each_missing(dropped, [&](std::uint32_t u) {
      if (--missing[u] == 1) ready.push_back(u);
    });
  }
  std::erase_if(kept, [&](std::uint32_t v) { return !test_bit(alive, v); });
}

void ReducedGraph::keep(const std::vector<std::uint32_t>& kept) {
  BitGraph left;
  left.assign_subgraph(rest(), kept);
  graph_ = std::move(left);
  original_ = false;
  const std::vector<std::uint32_t> names = std::exchange(names_, {});
  const std::vector<std::uint32_t> core = std::exchange(numbers_.core, {});
  for (const std::uint32_t v : kept) {
    names_.push_back(names[v]);
    numbers_.core.push_back(core[v]);
  }
  numbers_.order.resize(kept.size());
  std::iota(numbers_.order.rbegin(), numbers_.order.rend(), 0U);
}

}  // namespace consimd::detail
