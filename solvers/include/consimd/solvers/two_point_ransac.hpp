// Two-point RANSAC on angle consistency: the second filter of TCF (algorithm 2 of the paper).
#pragma once

#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/consensus_set.hpp>

namespace CONSIMD_EXPORT consimd {

/// Which angles the test compares.
enum class AngleTest : std::uint8_t {
  rotation_invariant,  ///< angle(p_i p_m p_j) against angle(q_i q_m q_j), by the angle-consistency kernel
  as_printed,  ///< Eq. (alpha-angle): angle(p_i p_m q_i) + angle(p_j p_m q_j) with q_m laid on p_m, which needs clouds
               ///< that are hardly rotated
};

struct TwoPointOptions {
  double consistency_bound = 0.0;  ///< of lengths, caller's unit; the paper's 2 tau
  double angle_bound = 0.0;  ///< distance whose arcsines bound the angle; the paper's tau, its authors' code uses 2 tau
  double confidence = 0.99;  ///< lambda of Eq. (nt-2pt)
  std::uint32_t max_iterations = 10'000;
  AngleTest angle_test = AngleTest::rotation_invariant;
  bool prune = true;  ///< as in OnePointOptions; also draws only pairs that are length consistent themselves
  std::uint64_t seed = 1;
};

/// The largest subset of `candidates` consistent in length and angle with a random pair of them.
/// candidates: rows of `correspondences`, any order. Throws std::invalid_argument on a bad option. Fewer than two
/// candidates come back as they are.
[[nodiscard]] ConsensusSet two_point_ransac(const Correspondences& correspondences,
                                            std::span<const std::uint32_t> candidates, const TwoPointOptions& options);

}  // namespace consimd
