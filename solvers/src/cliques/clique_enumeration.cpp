#include "cliques/clique_enumeration.hpp"

namespace consimd::detail {

bool CliqueEnumeration::start(const GraphView& graph, std::span<const std::uint32_t> rank, std::uint32_t vertex,
                              const Limits& limits) {
  limits_ = limits;
  nodes_ = 0;
  cliques_ = 0;
  complete_ = true;
  const std::span<const std::uint64_t> row = graph.row(vertex);
  neighbours_.clear();
  std::size_t later = 0;
  for_each_in(row, [&](std::uint32_t u) {
    if (u == vertex) return;
    if (rank[u] > rank[vertex]) ++later;
    neighbours_.emplace_back(and_popcount(row, graph.row(u)), u);
  });
  if (later + 1 < limits.min_size) return false;
  std::ranges::sort(neighbours_, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
  vertices_.clear();
  for (const auto& [common, u] : neighbours_) vertices_.push_back(u);
  graph_.assign_subgraph(graph, vertices_);
  Level& first = level_at(0);
  std::ranges::fill(first.candidates, 0);
  std::ranges::fill(first.excluded, 0);
  for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
    set_bit(rank[vertices_[i]] > rank[vertex] ? first.candidates : first.excluded, i);
  }
  clique_.assign(1, static_cast<std::uint32_t>(vertices_.size()));
  vertices_.push_back(vertex);
  return true;
}

CliqueEnumeration::Level& CliqueEnumeration::level_at(std::size_t depth) {
  if (levels_.size() <= depth) levels_.resize(depth + 1);
  Level& level = levels_[depth];
  for (std::vector<std::uint64_t>* set : {&level.candidates, &level.excluded, &level.branches}) {
    set->resize(graph_.words());
  }
  return level;
}

void CliqueEnumeration::choose_branches(Level& level) {
  const GraphView graph = graph_;
  std::uint32_t pivot = 0;
  std::uint32_t most = 0;
  bool chosen = false;
  for (const std::vector<std::uint64_t>* set : {&level.candidates, &level.excluded}) {
    for_each_in(*set, [&](std::uint32_t u) {
      const std::uint32_t covered = and_popcount(level.candidates, graph.row(u));
      if (chosen && covered <= most) return;
      chosen = true;
      most = covered;
      pivot = u;
    });
  }
  const std::span<const std::uint64_t> row = graph.row(pivot);
  for (std::size_t w = 0; w < row.size(); ++w) level.branches[w] = level.candidates[w] & ~row[w];
}

}  // namespace consimd::detail
