// Three-point RANSAC on alignment residuals: the coarse pose of TCF, Eq. (trans-estimate-ransac-3).
#pragma once

#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/consensus_set.hpp>

namespace CONSIMD_EXPORT consimd {

struct ThreePointOptions {
  double noise_bound = 0.0;  ///< tau, caller's unit
  double confidence = 0.99;  ///< lambda of Eq. (ransac-nt) with s = 3
  std::uint32_t max_iterations = 10'000;
  std::uint64_t seed = 1;
};

struct ThreePointResult {
  ConsensusSet consensus;  ///< candidates within noise_bound of the best pose; score = their number
  RigidTransform pose = RigidTransform::Identity();  ///< the best minimal pose, working frame
};

/// The minimal pose with most candidates within noise_bound. candidates: rows of `correspondences`.
/// Throws std::invalid_argument on a bad option. Fewer than three candidates give an empty consensus.
[[nodiscard]] ThreePointResult three_point_ransac(const Correspondences& correspondences,
                                                  std::span<const std::uint32_t> candidates,
                                                  const ThreePointOptions& options);

}  // namespace consimd
