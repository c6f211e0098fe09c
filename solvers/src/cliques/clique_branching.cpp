#include "cliques/clique_branching.hpp"

#include <algorithm>

#include "bits/bit_rows.hpp"

namespace consimd::detail {

namespace {

// Nodes between looks at the condition, of some microseconds together.
constexpr std::uint64_t kNodesBetweenLooks = 64;

}  // namespace

void CliqueBranching::run(const GraphView& graph, std::uint32_t wanted, std::uint64_t max_nodes, std::uint64_t max_work,
                          const StopCondition& stop) {
  graph_ = &graph;
  wanted_ = wanted;
  max_nodes_ = max_nodes;
  max_work_ = max_work;
  stop_ = stop;
  nodes_ = 0;
  work_ = 0;
  complete_ = true;
  clique_.clear();
  current_.clear();
  branches_.clear();
  uncoloured_.resize(graph.words());
  colour_class_.resize(graph.words());
  const std::span<std::uint64_t> all = candidates_at(0);
  std::ranges::fill(all, 0);
  for (std::size_t v = 0; v < graph.size(); ++v) set_bit(all, v);
  expand(0);
}

std::span<std::uint64_t> CliqueBranching::candidates_at(std::size_t depth) {
  if (candidates_.size() <= depth) candidates_.resize(depth + 1);
  if (candidates_[depth].size() < graph_->words()) candidates_[depth].resize(graph_->words());
  return std::span(candidates_[depth]).first(graph_->words());
}

void CliqueBranching::expand(std::size_t depth) {
  if (nodes_ == max_nodes_ || work_ >= max_work_ || (nodes_ % kNodesBetweenLooks == 0 && stop_.met())) {
    complete_ = false;
    return;
  }
  ++nodes_;
  const auto size = static_cast<std::uint32_t>(current_.size());
  const std::span<std::uint64_t> candidates = candidates_at(depth);
  const std::size_t first = branches_.size();
  colour(candidates, wanted_ > size ? wanted_ - size : 0);
  while (branches_.size() > first && complete_) {
    const Branch branch = branches_.back();
    branches_.pop_back();
    if (size + branch.colours < wanted_) break;  // a larger clique was found meanwhile
    current_.push_back(branch.vertex);
    const std::span<std::uint64_t> next = candidates_at(depth + 1);
    intersect(candidates, graph_->row(branch.vertex), next);
    clear_bit(next, branch.vertex);
    if (is_empty(next)) {
      if (current_.size() >= wanted_) {
        clique_ = current_;
        wanted_ = static_cast<std::uint32_t>(current_.size()) + 1;
      }
    } else {
      expand(depth + 1);
    }
    current_.pop_back();
    clear_bit(candidates, branch.vertex);
  }
  branches_.resize(first);
}

// Appends the candidates of colour `least` and above to branches_, in the order they are coloured. Every clique of
// `least` candidates has one of these as its last.
void CliqueBranching::colour(std::span<const std::uint64_t> candidates, std::uint32_t least) {
  std::ranges::copy(candidates, uncoloured_.begin());
  std::uint32_t colours = 0;
  std::size_t begin = 0;  // words before it are empty
  const std::size_t end = candidates.size();
  while (true) {
    while (begin < end && uncoloured_[begin] == 0) ++begin;
    if (begin == end) return;
    ++colours;
    std::copy(uncoloured_.begin() + static_cast<std::ptrdiff_t>(begin), uncoloured_.end(),
              colour_class_.begin() + static_cast<std::ptrdiff_t>(begin));
    for (std::size_t w = begin; w < end; ++w) {
      while (colour_class_[w] != 0) {
        const auto bit = static_cast<std::size_t>(std::countr_zero(colour_class_[w]));
        const auto vertex = static_cast<std::uint32_t>(w * kBlock + bit);
        const std::uint64_t* row = graph_->row(vertex).data();
        uncoloured_[w] &= ~(std::uint64_t{1} << bit);
        colour_class_[w] &= colour_class_[w] - 1;
        for (std::size_t k = w; k < end; ++k) colour_class_[k] &= ~row[k];
        work_ += kRowWork + end - w;
        if (colours >= least) branches_.push_back({vertex, colours});
      }
    }
  }
}

}  // namespace consimd::detail
