// TCF as printed in the paper, for comparison.
// P. Shi et al., "RANSAC Back to SOTA: A Two-stage Consensus Filtering for Real-time 3D Registration", RA-L 2024.
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct TcfPublishedOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  double confidence = 0.99;               ///< lambda, of each of the three sampling stages; in (0, 1)
  std::uint32_t max_iterations = 10'000;  ///< of each of them
  /// Noise bounds that `noise_bound` was chosen from by looking at the data; each gives chance another try.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Registers with algorithms 1 to 4 of the paper one after the other, each on what the one before kept, with the
/// paper's constants: no pruning, Eq. (alpha-angle) as printed, the stop of the Cauchy IRLS in metres. It needs clouds
/// that are hardly rotated against each other, and fails where outliers exceed about 95 %. The paper takes any pose for
/// a success; here the rules of all solvers judge it, and where a pose near it has more than five fourths of its
/// supporters it is ambiguous. Parallel over hypotheses in the caller's oneTBB arena;
/// the result has the same bits for any number of threads and every ISA. Throws std::invalid_argument on a bad option.
[[nodiscard]] Registration register_tcf_published(const Correspondences& correspondences,
                                                  const TcfPublishedOptions& options);

}  // namespace consimd
