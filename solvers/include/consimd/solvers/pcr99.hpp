// PCR-99: triples of correspondences in the order of how well their pairs agree in length with all others.
// S. H. Lee, J. Civera, P. Vandewalle, "PCR-99: A Practical Method for Point Cloud Registration with 99 Percent
// Outliers", 2024.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/pose_ranking.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct Pcr99Options {
  /// tau: the largest residual of an inlier, caller's unit of the target; finite and > 0. 3 sigma per axis is the usual
  /// choice.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;  ///< of the significance test, and of the scale's voters; the search itself draws nothing
  /// Find the scale of the source as well (see scale_voting.hpp).
  bool estimate_scale = false;
  /// A pair is bad when the logarithm of the ratio of its two lengths exceeds this; in (0, 1].
  double ratio_tolerance = 0.1;
  /// ... or when the lengths differ by this many noise bounds or more; > 0. Two keep every pair of inliers. The
  /// published test is that of the ratio alone: infinity.
  double length_tolerance = 2.0;
  /// The same for the costs that rank correspondences; > 0. Pairs of inliers rarely differ by more than one noise
  /// bound. Published: infinity.
  double ranking_tolerance = 1.0;
  /// Residuals below this many noise bounds count when hypotheses are scored; > 0. Published: 5 sigma, five thirds.
  double inlier_tolerance = 5.0 / 3.0;
  /// Hypotheses scored together, > 0; the search stops after a batch that has a significant pose.
  std::uint32_t batch = 1000;
  /// Triples of which the best connected gets a pose, > 0: one in the first batch, all as published, then twice as many
  /// from batch to batch up to this number (see keep_best_connected). The longer a search takes the choosier it is.
  std::uint32_t max_screened = 16;
  /// Hypotheses at most, and triples looked at, > 0.
  std::uint32_t max_hypotheses = 100'000;
  std::uint64_t max_triples = 1'000'000'000;
  /// Support that ranks the hypotheses.
  PoseRanking ranking = PoseRanking::inlier_count;
  /// Memory for the matrix of good pairs. If more correspondences are given than fit, triples are of the best-ranked;
  /// poses are still judged by all. The report of the stage "pairs" tells how many.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Cost of each correspondence i, N: the sum over all others j of min(d_ij, 1), d_ij the disagreement of their lengths
/// in units of the tolerances (see length_ratio.hpp). Low for inliers, which agree with all other inliers.
[[nodiscard]] std::vector<float> ranking_costs(const Correspondences& correspondences, const Pcr99Options& options);

/// Triples i < j < k of rows whose three pairs are all set in a symmetric bit matrix without its diagonal, in the order
/// of i + j + k, then of i, then of j: those of the first rows first.
class RankedTriples {
 public:
  /// Keeps a reference to the matrix.
  explicit RankedTriples(const ConsistencyMatrix& matrix);

  /// Replaces `triples` by the next `count`, or as many as are left or are found before `max_looked_at` triples have
  /// been looked at in all calls.
  void next(std::size_t count, std::uint64_t max_looked_at, std::vector<IndexTriple>& triples);

  [[nodiscard]] std::uint64_t looked_at() const noexcept { return looked_at_; }
  /// Whether no triple is left.
  [[nodiscard]] bool done() const noexcept;

 private:
  const ConsistencyMatrix& matrix_;
  std::size_t sum_ = 3;  // i + j + k
  std::size_t first_ = 0;
  std::uint64_t looked_at_ = 0;
  std::vector<IndexTriple> found_;  // beyond what was asked for
};

/// Leaves of `triples` the `count` best connected, those whose three rows have most neighbours in common, the earlier
/// ones of equals, in the order they were in; all of fewer. Supporters of the pose of three inliers agree in length
/// with all three: most of them are such neighbours.
void keep_best_connected(const ConsistencyMatrix& matrix, std::size_t count, std::vector<IndexTriple>& triples);

/// Registers with PCR-99: minimal poses of ranked triples whose pairs are all good, scored in batches on all
/// correspondences, then the refinement and the tests of the default solver. Parallel in the caller's oneTBB arena; the
/// result has the same bits for any number of threads and every ISA. Throws std::invalid_argument on a bad option.
[[nodiscard]] Registration register_pcr99(const Correspondences& correspondences, const Pcr99Options& options);

}  // namespace consimd
