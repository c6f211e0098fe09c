#include <consimd/solvers/maximum_clique.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "bits/bit_rows.hpp"
#include "cliques/clique_branching.hpp"
#include "cliques/clique_reduction.hpp"

namespace consimd {
namespace detail {
namespace {

// Greedy cliques from so many vertices, spread over all, come before the first reduction.
constexpr std::size_t kFirstStarts = 16;
// Vertices looked at with the same bound: enough to keep many threads busy. Fewer where a round of so many would take
// more than a quarter of the work that is left.
constexpr std::size_t kRound = 256;
constexpr std::size_t kSmallestRound = 16;
constexpr std::uint64_t kRoundsLeft = 4;
constexpr std::size_t kSearchRound = 32;
// Degrees within the candidates are counted again once these have shrunk to this share.
constexpr double kRecount = 0.75;
// Members whose degrees are counted before those among them that go are dropped.
constexpr std::size_t kCounted = 16;

/// The neighbourhood of a vertex, reduced to what a clique of the wanted size can hold.
class Neighbourhood {
 public:
  /// All of it. Returns whether it may hold `wanted` pairwise adjacent vertices; if so `members` are those that may be
  /// among them.
  bool assign(const GraphView& graph, std::uint32_t vertex, std::size_t candidates, std::uint32_t wanted) {
    set_.assign(graph.words(), 0);
    const std::span<const std::uint64_t> row = graph.row(vertex);
    const std::size_t words = words_for(candidates);
    std::copy_n(row.begin(), words, set_.begin());
    if (candidates % kBlock != 0) set_[words - 1] &= (std::uint64_t{1} << (candidates % kBlock)) - 1;
    clear_bit(set_, vertex);
    list();
    return prune(graph, wanted) && takes_colours(graph, wanted);
  }

  /// The members, highest degree first.
  void list_by_degree(std::vector<std::uint32_t>& vertices) {
    rank();
    std::ranges::sort(keys_, std::ranges::greater{});
    vertices.clear();
    for (const std::uint64_t key : keys_) vertices.push_back(vertex_of(key));
  }

  /// Takes the vertex of highest degree among the candidates, again and again, unless too few are left for `wanted`.
  void take_greedily(const GraphView& graph, std::uint32_t wanted, std::vector<std::uint32_t>& clique) {
    while (!members_.empty()) {
      const std::size_t counted = members_.size();
      std::size_t left = counted;
      // Few are taken before the degrees are counted again: a heap, not a sort.
      rank();
      std::ranges::make_heap(keys_);
      while (!keys_.empty() && static_cast<double>(left) >= kRecount * static_cast<double>(counted)) {
        const std::uint32_t taken = vertex_of(keys_.front());
        std::ranges::pop_heap(keys_);
        keys_.pop_back();
        if (!test_bit(set_, taken)) continue;
        clique.push_back(taken);
        intersect(set_, graph.row(taken), set_);
        work_ += kRowWork + set_.size();
        clear_bit(set_, taken);
        left = popcount(set_);
        if (clique.size() + left < wanted) return;
      }
      list();
      degrees_.resize(members_.size());
      count(graph, members_, degrees_);
    }
  }

  /// Work done since the last call.
  std::uint64_t take_work() noexcept { return std::exchange(work_, 0); }

 private:
  // Drops members until each is adjacent to `wanted` - 1 others or more. Returns false if fewer than `wanted` are left.
  // Which are left does not depend on the order: so those that go are missed by the very next counts. Those peeled
  // first have the fewest neighbours and come last: from the end on most go before the others are counted.
  bool prune(const GraphView& graph, std::uint32_t wanted) {
    std::array<std::uint32_t, kCounted> degrees{};
    degrees_.resize(members_.size());
    while (true) {
      const std::size_t size = members_.size();
      std::size_t kept = size;  // where those that stay begin
      for (std::size_t end = size; end > 0;) {
        if (end + (size - kept) < wanted) return false;
        const std::size_t first = end - std::min(end, kCounted);
        const std::span<const std::uint32_t> some = std::span(members_).subspan(first, end - first);
        count(graph, some, std::span(degrees).first(some.size()));
        for (std::size_t i = some.size(); i-- > 0;) {
          if (degrees[i] + 1 < wanted) {
            clear_bit(set_, some[i]);
          } else {
            degrees_[--kept] = degrees[i];
            members_[kept] = some[i];
          }
        }
        end = first;
      }
      members_.erase(members_.begin(), members_.begin() + static_cast<std::ptrdiff_t>(kept));
      degrees_.erase(degrees_.begin(), degrees_.begin() + static_cast<std::ptrdiff_t>(kept));
      if (members_.size() < wanted) return false;
      if (kept == 0) return true;
    }
  }

  /// Whether a greedy colouring takes `wanted` colours: fewer, and no clique is that large.
  bool takes_colours(const GraphView& graph, std::uint32_t wanted) {
    uncoloured_ = set_;
    colour_class_.resize(set_.size());
    std::size_t left = members_.size();
    std::size_t begin = 0;  // words before it are empty
    for (std::uint32_t colours = 0; colours < wanted; ++colours) {
      if (colours + left < wanted) return false;
      while (uncoloured_[begin] == 0) ++begin;
      std::ranges::copy(uncoloured_, colour_class_.begin());
      for (std::size_t w = begin; w < colour_class_.size(); ++w) {
        while (colour_class_[w] != 0) {
          const auto bit = static_cast<std::size_t>(std::countr_zero(colour_class_[w]));
          const std::uint64_t* row = graph.row(w * kBlock + bit).data();
          uncoloured_[w] &= ~(std::uint64_t{1} << bit);
          colour_class_[w] &= colour_class_[w] - 1;
          for (std::size_t k = w; k < colour_class_.size(); ++k) colour_class_[k] &= ~row[k];
          work_ += kRowWork + colour_class_.size() - w;
          --left;
        }
      }
    }
    return true;
  }

  void list() {
    members_.clear();
    for_each_in(set_, [&](std::uint32_t v) { members_.push_back(v); });
  }

  // Degrees within the set.
  void count(const GraphView& graph, std::span<const std::uint32_t> vertices, std::span<std::uint32_t> degrees) {
    work_ += vertices.size() * (kRowWork + set_.size());
    and_popcount_rows(graph.bits(), set_, vertices, degrees);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (graph.adjacent(vertices[i], vertices[i])) --degrees[i];
    }
  }

  // Keys that order the members by degree, then the lower vertex first.
  void rank() {
    keys_.clear();
    for (std::size_t i = 0; i < members_.size(); ++i) keys_.push_back(std::uint64_t{degrees_[i]} << 32 | ~members_[i]);
  }
  static std::uint32_t vertex_of(std::uint64_t key) noexcept { return ~static_cast<std::uint32_t>(key); }

  std::vector<std::uint64_t> set_;
  std::vector<std::uint32_t> members_;  // of the set
  std::vector<std::uint32_t> degrees_;  // of the members
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint64_t> uncoloured_;
  std::vector<std::uint64_t> colour_class_;
  std::uint64_t work_ = 0;
};

struct Scratch {
  Neighbourhood neighbourhood;
  std::vector<std::uint32_t> vertices;
  BitGraph graph;
  CliqueBranching branching;
};

class MaximumCliqueSearch {
 public:
  MaximumCliqueSearch(const GraphView& graph, const MaximumCliqueOptions& options)
      : reduced_(graph, options.larger_than),
        larger_than_(options.larger_than),
        nodes_left_(options.max_nodes),
        work_left_(options.max_work),
        stop_(options.stop) {}

  MaximumClique run() {
    const std::size_t size = reduced_.rest().size();
    std::vector<std::uint32_t> starts(std::min(kFirstStarts, size));
    for (std::size_t i = 0; i < starts.size(); ++i) starts[i] = static_cast<std::uint32_t>(i * size / starts.size());
    grow(starts);
    reduced_.reduce();
    starts.clear();
    for (std::uint32_t v = 0; v < reduced_.rest().size(); ++v) starts.push_back(v);
    for (std::span<const std::uint32_t> left = starts; !left.empty() && work_left_ > 0 && !stop_.met();) {
      const std::span<const std::uint32_t> round = left.first(std::min(round_size(), left.size()));
      left = left.subspan(round.size());
      grow(round);
    }
    reduced_.reduce();
    MaximumClique result;
    result.proven = search();
    if (reduced_.best().size() > larger_than_) result.members = reduced_.best();
    result.nodes = nodes_;
    result.work = work_;
    std::ranges::sort(result.members);
    return result;
  }

 private:
  void spend(std::uint64_t work) {
    work_ += work;
    work_left_ -= std::min(work_left_, work);
  }

  // Starts of the next round: by what those of the last one cost.
  [[nodiscard]] std::size_t round_size() const {
    const std::uint64_t affordable = work_left_ / (kRoundsLeft * std::max<std::uint64_t>(work_of_start_, 1));
    return std::clamp<std::uint64_t>(affordable, kSmallestRound, kRound);
  }

  // Offers greedy cliques around `starts`, and rules out those of which none could be larger than the best.
  void grow(std::span<const std::uint32_t> starts) {
    const GraphView graph = reduced_.rest();
    cliques_.assign(starts.size(), {});
    hopeless_.assign(starts.size(), 0);
    work_of_.assign(starts.size(), 0);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, starts.size(), 1), [&](const auto& range) {
      Neighbourhood& neighbourhood = scratch_.local().neighbourhood;
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        if (reduced_.core()[starts[i]] + 1 < reduced_.wanted()) continue;
        if (!neighbourhood.assign(graph, starts[i], graph.size(), reduced_.wanted() - 1)) {
          hopeless_[i] = 1;
        } else {
          cliques_[i].push_back(starts[i]);
          neighbourhood.take_greedily(graph, reduced_.wanted(), cliques_[i]);
        }
        work_of_[i] = neighbourhood.take_work();
      }
    });
    for (const std::vector<std::uint32_t>& clique : cliques_) reduced_.offer(clique);
    std::vector<std::uint32_t> hopeless;
    for (std::size_t i = 0; i < starts.size(); ++i) {
      if (hopeless_[i] != 0) hopeless.push_back(starts[i]);
    }
    reduced_.rule_out(hopeless);
    const std::uint64_t work = std::accumulate(work_of_.begin(), work_of_.end(), std::uint64_t{0});
    work_of_start_ = work / std::max<std::size_t>(starts.size(), 1);
    spend(work);
  }

  struct Budget {
    std::uint64_t nodes;
    std::uint64_t work;
  };

  // Returns whether the best clique is a maximum one.
  bool search() {
    const GraphView graph = reduced_.rest();
    bool proven = true;
    for (std::size_t first = 0; first < graph.size(); first += kSearchRound) {
      const std::uint32_t wanted = reduced_.wanted();
      if (reduced_.core()[first] + 1 < wanted) break;  // and so are all that follow
      if (nodes_left_ == 0 || work_left_ == 0 || stop_.met()) return false;
      const std::size_t count = std::min(kSearchRound, graph.size() - first);
      const Budget share{nodes_left_ / count, work_left_ / count};
      outcomes_.assign(count, {});
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          outcomes_[i] = search_from(graph, static_cast<std::uint32_t>(first + i), wanted, share);
        }
      });
      for (const Outcome& outcome : outcomes_) {
        reduced_.offer(outcome.clique);
        proven = proven && outcome.complete;
        nodes_left_ -= outcome.nodes;
        nodes_ += outcome.nodes;
        spend(outcome.work);
      }
    }
    return proven;
  }

  struct Outcome {
    std::vector<std::uint32_t> clique;
    bool complete = true;
    std::uint64_t nodes = 0;
    std::uint64_t work = 0;
  };

  // The largest clique of `vertex` and vertices that were peeled after it.
  Outcome search_from(const GraphView& graph, std::uint32_t vertex, std::uint32_t wanted, const Budget& share) {
    Outcome outcome;
    if (reduced_.core()[vertex] + 1 < wanted) return outcome;
    Scratch& scratch = scratch_.local();
    const bool hopeful = scratch.neighbourhood.assign(graph, vertex, vertex, wanted - 1);
    outcome.work = scratch.neighbourhood.take_work();
    if (!hopeful) return outcome;
    scratch.neighbourhood.list_by_degree(scratch.vertices);
    scratch.graph.assign_subgraph(graph, scratch.vertices);
    scratch.branching.run(scratch.graph, std::max(wanted, 2U) - 1, share.nodes, share.work, stop_);
    outcome.complete = scratch.branching.complete();
    outcome.nodes = scratch.branching.nodes();
    outcome.work += scratch.branching.work();
    if (scratch.branching.clique().size() + 1 < wanted) return outcome;
    outcome.clique.push_back(vertex);
    for (const std::uint32_t i : scratch.branching.clique()) outcome.clique.push_back(scratch.vertices[i]);
    return outcome;
  }

  ReducedGraph reduced_;
  std::uint32_t larger_than_;
  std::uint64_t nodes_left_;
  std::uint64_t work_left_;
  StopCondition stop_;
  std::uint64_t nodes_ = 0;
  std::uint64_t work_ = 0;
  std::uint64_t work_of_start_ = 0;  // mean of the last round
  std::vector<std::uint64_t> work_of_;
  std::vector<std::vector<std::uint32_t>> cliques_;
  std::vector<std::uint8_t> hopeless_;
  std::vector<Outcome> outcomes_;
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace
}  // namespace detail

MaximumClique maximum_clique(const GraphView& graph, const MaximumCliqueOptions& options) {
  return detail::MaximumCliqueSearch(graph, options).run();
}

}  // namespace consimd
