// TurboReg: three-cliques of an ordered graph of second-order spatial compatibility.
// S. Yan et al., "TurboReg: TurboClique for Robust and Efficient Point Cloud Registration", ICCV 2025.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/pose_ranking.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct TurboRegOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0. 3 sigma per axis is the usual choice.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  /// Two correspondences are compatible when their lengths differ by less than this many noise bounds; finite and > 0.
  double length_tolerance = 0.25;
  /// ... and add up to more than this many noise bounds; finite and > 0. Short pairs determine a pose badly.
  double separation = 1.5;
  /// Edges of most common neighbours that cliques are searched from, > 0.
  std::uint32_t pivots = 2000;
  /// Cliques kept of each pivot, > 0.
  std::uint32_t cliques_per_pivot = 2;
  /// Support that ranks the cliques' poses.
  PoseRanking ranking = PoseRanking::inlier_count;
  /// Memory for the pairwise compatibility matrix. If more correspondences are given than fit, the graph is that of a
  /// random sample; poses are still judged by all. The report of the stage "compatibility" tells how many.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// The `count` edges (first < second) whose ends have most common neighbours, at least one; most first, ties in the
/// order of their rows. matrix: without its diagonal (`compute_separated`).
[[nodiscard]] std::vector<IndexPair> strongest_edges(const ConsistencyMatrix& matrix, std::size_t count);

/// Three-cliques i < j < k of pivots (i, j): for each the `per_pivot` rows k of largest w_ij + w_ik + w_jk (ties: the
/// lowest), w the number of common neighbours. All best ones in the order of the pivots, then all second-best ones, and
/// so on; a pivot without common neighbours beyond j has none. Matrix as above.
[[nodiscard]] std::vector<IndexTriple> pivot_cliques(const ConsistencyMatrix& matrix, std::span<const IndexPair> pivots,
                                                     std::uint32_t per_pivot);

/// Registers with TurboReg: the pose of the three-clique with most support among all correspondences, then the
/// refinement and the tests of the default solver. Parallel in the caller's oneTBB arena; the result has the same bits
/// for any number of threads and every ISA. Throws std::invalid_argument on a bad option.
[[nodiscard]] Registration register_turboreg(const Correspondences& correspondences, const TurboRegOptions& options);

}  // namespace consimd
