// One-point RANSAC on length consistency: the first filter of TCF (algorithm 1 of the paper).
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/consensus_set.hpp>

namespace CONSIMD_EXPORT consimd {

struct OnePointOptions {
  double consistency_bound = 0.0;  ///< largest difference of two lengths, caller's unit; the paper's 2 tau
  double confidence = 0.99;        ///< of having drawn an inlier, lambda of Eq. (nt-1pt)
  std::uint32_t max_iterations = 10'000;
  /// Reduce each hypothesis' set to the members that agree with one another (see detail::prune). Without it the set of
  /// an outlier is often as large as that of an inlier once noise and outlier ratio are high.
  bool prune = true;
  std::uint64_t seed = 1;
};

/// The largest consensus set {j : | |p_j-p_k| - |q_j-q_k| | < consistency_bound} over random correspondences k.
/// Throws std::invalid_argument on a bad option. An empty input gives an empty set.
[[nodiscard]] ConsensusSet one_point_ransac(const Correspondences& correspondences, const OnePointOptions& options);

}  // namespace consimd
