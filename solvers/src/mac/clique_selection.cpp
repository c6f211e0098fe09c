#include "mac/clique_selection.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <utility>

#include "cliques/clique_enumeration.hpp"

namespace consimd::detail {
namespace {

constexpr std::size_t kRound = 256;  // vertices between two merges
constexpr std::uint32_t kSmallest = 3;
// Neighbourhoods up to this size keep the weights of their edges: each is asked for by many cliques.
constexpr std::size_t kKeptWeights = 1024;

/// Cliques around one vertex: of those visited, the heaviest for each member.
class CliquesAround {
 public:
  struct Result {
    std::vector<WeightedClique> cliques;
    std::uint64_t found = 0;
    bool complete = true;
  };

  Result run(const CompatibilityGraph& graph, std::span<const std::uint32_t> rank, std::uint32_t vertex,
             const CliqueEnumeration::Limits& limits, bool second_order) {
    Result result;
    started_ = false;
    enumeration_.run(graph.graph(), rank, vertex, limits, [&](std::span<const std::uint32_t> clique) {
      if (!started_) start();
      ++result.found;
      consider(graph, clique, second_order);
    });
    result.complete = enumeration_.complete();
    if (!started_) return result;
    std::vector<std::uint32_t> chosen(best_);
    std::ranges::sort(chosen);
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    for (const std::uint32_t c : chosen) {
      if (c == kNone) continue;
      WeightedClique& clique = result.cliques.emplace_back();
      clique.weight = weights_[c];
      for (std::size_t m = begins_[c]; m < begins_[c + 1]; ++m) {
        clique.rows.push_back(enumeration_.vertices()[members_[m]]);
      }
      std::ranges::sort(clique.rows);
    }
    return result;
  }

 private:
  static constexpr std::uint32_t kNone = ~0U;

  void start() {
    started_ = true;
    const std::size_t size = enumeration_.vertices().size();
    best_.assign(size, kNone);
    weights_.clear();
    begins_.assign(1, 0);
    members_.clear();
    edges_.assign(size <= kKeptWeights ? size * size : 0, -1.0F);
  }

  void consider(const CompatibilityGraph& graph, std::span<const std::uint32_t> clique, bool second_order) {
    float weight = 0.0F;
    for (std::size_t a = 0; a < clique.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) weight += edge(graph, clique[a], clique[b], second_order);
    }
    const auto candidate = static_cast<std::uint32_t>(weights_.size());
    bool kept = false;
    for (const std::uint32_t v : clique) {
      if (best_[v] != kNone && weights_[best_[v]] >= weight) continue;
      if (!std::exchange(kept, true)) {
        weights_.push_back(weight);
        members_.insert(members_.end(), clique.begin(), clique.end());
        begins_.push_back(members_.size());
      }
      best_[v] = candidate;
    }
  }

  float edge(const CompatibilityGraph& graph, std::uint32_t a, std::uint32_t b, bool second_order) {
    const std::vector<std::uint32_t>& vertices = enumeration_.vertices();
    const std::size_t key = std::size_t{std::max(a, b)} * vertices.size() + std::min(a, b);
    if (!edges_.empty() && edges_[key] >= 0.0F) return edges_[key];
    const auto [low, high] = std::minmax(vertices[a], vertices[b]);
    const float weight = graph.weight(low, high, second_order);
    if (!edges_.empty()) edges_[key] = weight;
    return weight;
  }

  CliqueEnumeration enumeration_;
  bool started_ = false;
  std::vector<std::uint32_t> best_;  // by position in the neighbourhood
  std::vector<float> weights_;       // of the cliques kept
  std::vector<std::size_t> begins_;  // of their members
  std::vector<std::uint32_t> members_;
  std::vector<float> edges_;
};

}  // namespace

SelectedCliques select_cliques(const CompatibilityGraph& graph, const MacOptions& options) {
  const std::size_t size = graph.graph().size();
  const std::vector<std::uint32_t> order = core_numbers(graph.graph()).order;
  std::vector<std::uint32_t> rank(size);
  for (std::uint32_t p = 0; p < size; ++p) rank[order[p]] = p;
  const CliqueEnumeration::Limits limits{kSmallest, std::max<std::uint64_t>(options.max_cliques / size, 1),
                                         std::max<std::uint64_t>(options.max_nodes / size, 1)};

  SelectedCliques selected;
  std::vector<WeightedClique> all;
  std::vector<std::size_t> best(size);  // position in `all`, plus 1; 0: none
  tbb::enumerable_thread_specific<CliquesAround> scratch;
  std::vector<CliquesAround::Result> results;
  for (std::size_t first = 0; first < size && !selected.stopped; first += kRound) {
    results.assign(std::min(kRound, size - first), {});
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, results.size(), 4), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        results[i] =
            scratch.local().run(graph, rank, static_cast<std::uint32_t>(first + i), limits, options.second_order);
      }
    });
    for (std::size_t i = 0; i < results.size(); ++i) {
      selected.found += results[i].found;
      if (!results[i].complete) selected.cut_short.push_back(static_cast<std::uint32_t>(first + i));
      for (WeightedClique& clique : results[i].cliques) {
        bool kept = false;
        for (const std::uint32_t row : clique.rows) {
          if (best[row] != 0 && all[best[row] - 1].weight >= clique.weight) continue;
          best[row] = all.size() + 1;  // where the clique goes
          kept = true;
        }
        if (kept) all.push_back(std::move(clique));
      }
    }
    selected.stopped = first + results.size() < size && options.stop.met();
  }
  std::ranges::sort(best);
  best.erase(std::unique(best.begin(), best.end()), best.end());
  for (const std::size_t b : best) {
    if (b != 0) selected.cliques.push_back(std::move(all[b - 1]));
  }
  std::ranges::stable_sort(selected.cliques, std::ranges::greater{}, &WeightedClique::weight);
  return selected;
}

}  // namespace consimd::detail
