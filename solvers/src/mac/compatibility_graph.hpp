// MAC's graph of compatible correspondences.
#pragma once

#include <cstdint>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/bit_graph.hpp>

namespace consimd::detail {

class CompatibilityGraph {
 public:
  /// Keeps the view, whose owner must live as long. With delta the difference of a pair's lengths in the two clouds,
  /// the first-order score is s = 1 - delta^2 / distance^2; pairs of s > threshold are compatible. Where that leaves
  /// more than `max_mean_degree` edges a vertex, only those stay whose ends have most common neighbours beyond chance,
  /// ties drawn at random.
  CompatibilityGraph(const CorrespondenceView& view, double distance, double threshold, double max_mean_degree,
                     std::uint64_t seed);

  /// The edges that cliques are looked for on.
  [[nodiscard]] GraphView graph() const noexcept {
    return sparse_.size() > 0 ? GraphView(sparse_) : GraphView(matrix_);
  }
  /// First order: s. Second order: s times the number of vertices that are compatible with both.
  [[nodiscard]] float weight(std::uint32_t i, std::uint32_t j, bool second_order) const;

 private:
  void sparsify(std::uint64_t max_edges, std::uint64_t seed);
  [[nodiscard]] std::uint32_t common_neighbours(std::uint32_t i, std::uint32_t j) const;
  [[nodiscard]] std::uint32_t significance_bin(std::uint32_t i, std::uint32_t j) const;

  CorrespondenceView view_;
  double squared_distance_;  // working frame
  ConsistencyMatrix matrix_;
  BitGraph sparse_;  // empty: the matrix is sparse enough
};

}  // namespace consimd::detail
