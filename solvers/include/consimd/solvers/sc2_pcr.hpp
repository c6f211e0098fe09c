// SC2-PCR: second-order spatial compatibility of correspondences.
// Z. Chen et al., "SC2-PCR: A Second Order Spatial Compatibility for Efficient and Robust Point Cloud Registration",
// CVPR 2022.
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

struct Sc2PcrOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0. 3 sigma per axis is the usual choice.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  /// Two correspondences are compatible when their lengths differ by less than this many noise bounds; finite and > 0.
  /// Common neighbours are counted with half of it, as in the published code.
  double length_tolerance = 1.0;
  /// Only the most confident of the correspondences whose sources are within this many noise bounds is a seed; finite
  /// and > 0.
  double seed_radius = 1.0;
  /// Seeds as a share of the correspondences, in (0, 1]. A few more are of those that the best pose does not explain.
  /// If these lead to no significant pose, the others follow.
  double seed_share = 0.2;
  /// Rounds of the power iteration for the confidence of correspondences, and for the weights within a set, > 0.
  std::uint32_t power_iterations = 10;
  /// Members of a seed's first and second consensus set, the seed included: 3 <= second_set <= first_set <= 64.
  std::uint32_t first_set = 30;
  std::uint32_t second_set = 20;
  /// Support that ranks the seeds' poses.
  PoseRanking ranking = PoseRanking::inlier_count;
  /// Memory for the two pairwise compatibility matrices. If more correspondences are given than fit, the matrices are
  /// those of a random sample; poses are still judged by all. The report of the stage "compatibility" tells how many.
  std::size_t matrix_budget_bytes = std::size_t{64} << 20;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// First-order compatibilities by two bounds.
struct CompatibilityMatrices {
  ConsistencyMatrix loose;  ///< lengths differ by less than d
  ConsistencyMatrix tight;  ///< by less than d / 2: common neighbours are counted in it

  /// Fills both. d: caller's unit, finite and > 0, as is d / 2. Throws as `ConsistencyMatrix::compute`.
  void compute(const CorrespondenceView& view, double d);
};

/// Confidence of each correspondence: the leading eigenvector of the matrix, of length 1, by power iteration from equal
/// entries; it ends early when no entry changes by more than 1e-5 of itself.
[[nodiscard]] std::vector<float> compatibility_confidence(const ConsistencyMatrix& matrix, std::uint32_t max_rounds);

/// `count` correspondences, most confident first: those that no more confident one has its source within `radius` of
/// (caller's unit), then, if these are fewer, the others. Ties: the lower row. confidence: N.
[[nodiscard]] std::vector<std::uint32_t> confidence_seeds(const CorrespondenceView& view,
                                                          std::span<const float> confidence, double radius,
                                                          std::size_t count);

/// A pose for each seed.
struct SeedPoses {
  std::vector<WorkingPose> poses;    ///< S; NaN where a set determines none
  std::vector<IndexTriple> leading;  ///< S: the seed and the two that agree most with its set; the seed thrice if none
  bool stopped = false;              ///< seeds that come late may have no pose for that
};

/// For each seed s the `first_set` compatible correspondences j of most common neighbours (SC2_sj), of these the
/// `second_set` that are compatible with most of them, and the least-squares pose of those, weighted by the leading
/// eigenvector of their max(0, 1 - (|p_i-p_j| - |q_i-q_j|)^2 / d^2), d = length_tolerance * noise_bound.
/// seeds: rows of the correspondences that the matrices are of.
[[nodiscard]] SeedPoses second_order_poses(const Correspondences& correspondences,
                                           const CompatibilityMatrices& matrices, std::span<const std::uint32_t> seeds,
                                           const Sc2PcrOptions& options);

/// Registers with SC2-PCR: the seed's pose with most support among all correspondences, then the refinement and the
/// tests of the default solver. Parallel over seeds in the caller's oneTBB arena; the result has the same bits for any
/// number of threads and every ISA. Throws std::invalid_argument on a bad option.
[[nodiscard]] Registration register_sc2_pcr(const Correspondences& correspondences, const Sc2PcrOptions& options);

}  // namespace consimd
