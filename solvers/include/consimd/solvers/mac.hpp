// MAC: a pose from each of the heaviest maximal cliques.
// X. Zhang, J. Yang, S. Zhang, Y. Zhang, "3D Registration with Maximal Cliques", CVPR 2023.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct MacOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0. 3 sigma per axis is the usual choice.
  double noise_bound = 0.0;
  /// Seeds the significance test, and the draw among edges of equal rank where a graph is thinned out.
  std::uint64_t seed = 1;
  /// d in noise bounds, > 0: pairs whose lengths differ by delta have the score s = 1 - delta^2 / d^2.
  double compatibility_distance = 1.0;
  /// Pairs with a score above it are edges; in [0, 1).
  double compatibility_threshold = 0.9;
  /// Weigh edges by s times the number of correspondences compatible with both ends, instead of s alone.
  bool second_order = true;
  /// A graph with more edges a vertex is thinned out to so many: those whose ends have most common neighbours beyond
  /// chance stay. Dense graphs have more maximal cliques than can be listed. > 0; infinity: never.
  double max_mean_degree = 64.0;
  /// Maximal cliques of three and more, and nodes of their search, at most. Each vertex has an even share, which it
  /// spends on its heaviest neighbours first.
  std::uint64_t max_cliques = 200'000;
  std::uint64_t max_nodes = 1'000'000;
  /// Heaviest cliques that poses are made of, at most.
  std::uint32_t max_hypotheses = 1000;
  /// Weigh a clique's correspondences by the leading eigenvector of its edge weights, instead of equally.
  bool weighted_fit = false;
  /// Memory for the graph, 1.1 MB for 3000 correspondences, 12.6 MB for 10 000; a thinned one takes as much again. A
  /// graph that needs more is an error.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Registers with MAC: the compatibility graph, its maximal cliques, for each vertex the heaviest that holds it, a fit
/// to each of these, the one of largest truncated quadratic score on all correspondences; then the refinement and the
/// tests of the default solver. The status is budget_exhausted when a pose of more support could hide among the
/// correspondences whose share of a budget ended: those that the pose does not explain are more than its supporters,
/// and compatible with as many others as that takes. Parallel over vertices and cliques in the caller's oneTBB arena;
/// the result has the same bits for any number of threads and every ISA. Throws std::invalid_argument on a bad option,
/// or if the graph exceeds its budget.
[[nodiscard]] Registration register_mac(const Correspondences& correspondences, const MacOptions& options);

}  // namespace consimd
