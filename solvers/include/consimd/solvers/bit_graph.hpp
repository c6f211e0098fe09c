// Undirected graphs as bit rows, such as the pairwise consistency of correspondences, and their k-cores.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

class BitGraph;

/// A borrowed graph of `size` vertices: bit j of row i tells whether i and j are adjacent. Rows are `words` 64-bit
/// words, size / 64 rounded up; bits from size on are 0. Symmetric; the diagonal is ignored. Valid while its owner
/// lives.
class GraphView {
 public:
  GraphView(const ConsistencyMatrix& matrix) noexcept  // NOLINT(google-explicit-constructor)
      : bits_(matrix.data()), size_(matrix.size()), words_(matrix.words()) {}
  GraphView(const BitGraph& graph) noexcept;  // NOLINT(google-explicit-constructor)

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t words() const noexcept { return words_; }
  [[nodiscard]] std::span<const std::uint64_t> row(std::size_t i) const noexcept {
    return {bits_ + i * words_, words_};
  }
  /// All rows, one after the other.
  [[nodiscard]] std::span<const std::uint64_t> bits() const noexcept { return {bits_, size_ * words_}; }
  [[nodiscard]] bool adjacent(std::size_t i, std::size_t j) const noexcept {
    return (bits_[i * words_ + j / kBlock] >> (j % kBlock) & 1) != 0;
  }

 private:
  const std::uint64_t* bits_;
  std::size_t size_;
  std::size_t words_;
};

/// A graph that owns its rows; size * words * 8 bytes.
class BitGraph {
 public:
  /// Without edges.
  explicit BitGraph(std::size_t size = 0) { assign_empty(size); }

  /// Drops everything; keeps its memory for the new vertices.
  void assign_empty(std::size_t size);
  /// Makes this the graph that `vertices`, all different, span in `parent`: vertex i is vertices[i]. Throws
  /// std::out_of_range on a bad vertex.
  void assign_subgraph(const GraphView& parent, std::span<const std::uint32_t> vertices);
  /// Makes two different vertices adjacent. Throws std::out_of_range on a bad vertex, std::invalid_argument if i == j.
  void connect(std::size_t i, std::size_t j);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t words() const noexcept { return words_; }
  [[nodiscard]] const std::uint64_t* data() const noexcept { return bits_.data(); }
  [[nodiscard]] std::span<std::uint64_t> row(std::size_t i) noexcept { return {bits_.data() + i * words_, words_}; }

 private:
  std::size_t size_ = 0;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;
  // Scratch of assign_subgraph.
  std::vector<std::uint64_t> chosen_;
  std::vector<std::uint32_t> positions_;
};

inline GraphView::GraphView(const BitGraph& graph) noexcept
    : bits_(graph.data()), size_(graph.size()), words_(graph.words()) {}

/// The core number of a vertex is the largest k such that it belongs to a subgraph whose vertices all have k neighbours
/// or more in it: a vertex of a clique of k + 1 has at least k.
struct CoreNumbers {
  std::vector<std::uint32_t> core;   ///< by vertex
  std::vector<std::uint32_t> order;  ///< a degeneracy order: vertices by the time they were peeled, core ascending
};

/// Bucket peeling in time proportional to the number of edges (V. Batagelj, M. Zaversnik, "An O(m) Algorithm for Cores
/// Decomposition of Networks", 2003).
[[nodiscard]] CoreNumbers core_numbers(const GraphView& graph);

/// The vertices of the largest core number, ascending; ROBIN's and TEASER's cheap stand-in for the maximum clique
/// (J. Shi et al., "ROBIN: a Graph-Theoretic Approach to Reject Outliers in Robust Estimation using Invariants", 2021).
[[nodiscard]] std::vector<std::uint32_t> maximum_core(const GraphView& graph);

}  // namespace consimd
