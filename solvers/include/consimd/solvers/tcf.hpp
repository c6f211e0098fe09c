// TCF, two-stage consensus filtering: one-point, two-point and three-point RANSAC, then a robust fit.
// P. Shi et al., "RANSAC Back to SOTA: A Two-stage Consensus Filtering for Real-time 3D Registration", RA-L 2024.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/point_pairs.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct TcfOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0. 3 sigma per axis is the usual choice.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  /// Probability that a seed of the pose with the largest support has been drawn when the search stops.
  double confidence = 0.99;
  /// Seeds drawn at most; when they end before the confidence is reached the status is budget_exhausted.
  std::uint32_t max_seeds = 10'000;
  /// Memory for the pairwise consistency matrix of all correspondences. It is built where it fits and the consensus
  /// sets are dense, or so sparse that all are looked at; elsewhere the matrices of the sets themselves are.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Registers with TCF. Parallel over hypotheses in the caller's oneTBB arena; the result has the same bits for any
/// number of threads and every ISA.
///
/// It differs from the paper (see tcf_published.hpp) where practice needs it: each one-point hypothesis is pruned to
/// the members that agree pairwise; not one but every promising set goes to the three-point stage; its poses are ranked
/// by their support among all correspondences; and the final fit re-selects inliers from all correspondences with the
/// posterior weights of Student inliers among uniform outliers (see pose_refinement.hpp). Throws std::invalid_argument
/// on a bad option.
[[nodiscard]] Registration register_tcf(const Correspondences& correspondences, const TcfOptions& options);

/// The same where source[k] is to be brought to target[k]: ranges of points, or matrices of Eigen's, see
/// point_pairs.hpp, which also tells what is thrown.
template <typename Source, typename Target>
[[nodiscard]] Registration register_tcf(const Source& source, const Target& target, const TcfOptions& options) {
  return register_tcf(point_pairs(source, target), options);
}

}  // namespace consimd
