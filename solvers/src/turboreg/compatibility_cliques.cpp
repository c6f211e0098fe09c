// The stages of TurboReg on a compatibility matrix: pivots, three-cliques.
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <tuple>

#include <consimd/solvers/turboreg.hpp>

#include "bits/bit_rows.hpp"

namespace consimd {
namespace {

constexpr std::size_t kRowsPerTask = 8;
constexpr std::size_t kPivotsPerTask = 16;

struct Edge {
  std::uint32_t weight;
  IndexPair rows;
};

/// A total order: the strongest edges are the same whatever order they are met in.
bool stronger(const Edge& a, const Edge& b) {
  return std::tie(b.weight, a.rows.first, a.rows.second) < std::tie(a.weight, b.rows.first, b.rows.second);
}

void keep_strongest(std::vector<Edge>& edges, std::size_t count) {
  if (edges.size() <= count) return;
  const auto end = edges.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(edges.begin(), end - 1, edges.end(), stronger);
  edges.erase(end, edges.end());
}

/// Clears the bits of rows below `first`.
void clear_below(std::span<std::uint64_t> bits, std::uint32_t first) {
  const std::size_t word = first / kBlock;
  std::fill_n(bits.begin(), word, 0);
  if (word < bits.size()) bits[word] &= ~std::uint64_t{0} << (first % kBlock);
}

/// The strongest of the edges that several threads meet.
class StrongestEdges {
 public:
  explicit StrongestEdges(std::size_t count) : count_(count) {}

  /// Edges of less weight are not among them.
  [[nodiscard]] std::uint32_t least_weight() const { return least_weight_.load(std::memory_order_relaxed); }

  void add(const Edge& edge) {
    std::vector<Edge>& edges = edges_.local();
    edges.push_back(edge);
    if (edges.size() < 2 * count_) return;
    keep_strongest(edges, count_);
    raise_least_weight(std::ranges::min(edges, {}, &Edge::weight).weight);
  }

  [[nodiscard]] std::vector<Edge> sorted() {
    std::vector<Edge> all;
    for (const std::vector<Edge>& edges : edges_) all.insert(all.end(), edges.begin(), edges.end());
    keep_strongest(all, count_);
    std::ranges::sort(all, stronger);
    return all;
  }

 private:
  void raise_least_weight(std::uint32_t weight) {
    std::uint32_t known = least_weight();
    while (known < weight && !least_weight_.compare_exchange_weak(known, weight, std::memory_order_relaxed)) {
    }
  }

  std::size_t count_;
  std::atomic<std::uint32_t> least_weight_ = 1;
  tbb::enumerable_thread_specific<std::vector<Edge>> edges_;
};

/// Scratch of one thread.
struct RowScratch {
  std::vector<std::uint64_t> bits;
  std::vector<std::uint32_t> neighbours;
  std::vector<std::uint32_t> counts;
  std::vector<std::uint32_t> second_counts;
};

}  // namespace

std::vector<IndexPair> strongest_edges(const ConsistencyMatrix& matrix, std::size_t count) {
  if (count == 0 || matrix.size() == 0) return {};
  const std::span<const std::uint32_t> degrees = matrix.degrees();
  // From the rows of many neighbours on, so that few edges of the others can be among the strongest: the ends of an
  // edge of weight w have w + 1 neighbours or more.
  std::vector<std::uint32_t> order(matrix.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t row) { return degrees[row]; });

  StrongestEdges strongest(count);
  tbb::enumerable_thread_specific<RowScratch> scratches;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), kRowsPerTask), [&](const auto& range) {
    RowScratch& scratch = scratches.local();
    for (std::size_t position = range.begin(); position < range.end(); ++position) {
      const std::uint32_t row = order[position];
      const std::uint32_t least_weight = strongest.least_weight();
      if (degrees[row] <= least_weight) return;
      scratch.bits.assign(matrix.row(row).begin(), matrix.row(row).end());
      clear_below(scratch.bits, row + 1);
      detail::members_of(scratch.bits, scratch.neighbours);
      std::erase_if(scratch.neighbours, [&](std::uint32_t other) { return degrees[other] <= least_weight; });
      scratch.counts.resize(scratch.neighbours.size());
      and_popcount_rows(matrix, matrix.row(row), scratch.neighbours, scratch.counts);
      for (std::size_t k = 0; k < scratch.counts.size(); ++k) {
        if (scratch.counts[k] >= strongest.least_weight()) {
          strongest.add({scratch.counts[k], {row, scratch.neighbours[k]}});
        }
      }
    }
  });
  std::vector<IndexPair> pivots;
  for (const Edge& edge : strongest.sorted()) pivots.push_back(edge.rows);
  return pivots;
}

std::vector<IndexTriple> pivot_cliques(const ConsistencyMatrix& matrix, std::span<const IndexPair> pivots,
                                       std::uint32_t per_pivot) {
  constexpr std::uint32_t kNone = 0xffffffff;
  per_pivot = std::min(per_pivot, static_cast<std::uint32_t>(matrix.size()));
  std::vector<std::uint32_t> thirds(pivots.size() * per_pivot, kNone);
  tbb::enumerable_thread_specific<RowScratch> scratches;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pivots.size(), kPivotsPerTask), [&](const auto& range) {
    RowScratch& scratch = scratches.local();
    for (std::size_t p = range.begin(); p < range.end(); ++p) {
      const std::span<const std::uint64_t> first = matrix.row(pivots[p].first);
      const std::span<const std::uint64_t> second = matrix.row(pivots[p].second);
      scratch.bits.resize(matrix.words());
      for (std::size_t w = 0; w < matrix.words(); ++w) scratch.bits[w] = first[w] & second[w];
      clear_below(scratch.bits, pivots[p].second + 1);
      std::vector<std::uint32_t>& candidates = scratch.neighbours;
      detail::members_of(scratch.bits, candidates);
      scratch.counts.resize(candidates.size());
      scratch.second_counts.resize(candidates.size());
      and_popcount_rows(matrix, first, candidates, scratch.counts);
      and_popcount_rows(matrix, second, candidates, scratch.second_counts);
      // w_ij is the same for all.
      for (std::size_t k = 0; k < candidates.size(); ++k) scratch.counts[k] += scratch.second_counts[k];
      for (std::uint32_t place = 0; place < per_pivot && place < candidates.size(); ++place) {
        const auto best = std::ranges::max_element(scratch.counts) - scratch.counts.begin();
        thirds[place * pivots.size() + p] = candidates[static_cast<std::size_t>(best)];
        scratch.counts[static_cast<std::size_t>(best)] = 0;
      }
    }
  });
  std::vector<IndexTriple> cliques;
  cliques.reserve(thirds.size());
  for (std::size_t t = 0; t < thirds.size(); ++t) {
    const IndexPair& pivot = pivots[t % pivots.size()];
    if (thirds[t] != kNone) cliques.push_back({pivot.first, pivot.second, thirds[t]});
  }
  return cliques;
}

}  // namespace consimd
