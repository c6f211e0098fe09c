// RANSAC on three-point samples, the baseline that every other solver is held against.
// M. A. Fischler, R. C. Bolles, "Random Sample Consensus: A Paradigm for Model Fitting with Applications to Image
// Analysis and Automated Cartography", Communications of the ACM 24, 1981.
#pragma once

#include <cstdint>
#include <optional>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct RansacOptions {
  /// tau: the largest residual of an inlier, caller's unit; finite and > 0. 3 sigma per axis is the usual choice.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  /// Samples drawn at most; those that the length check turns down count.
  std::uint32_t max_iterations = 50'000;
  /// Probability that a sample of the best pose's supporters has been drawn when the search stops, in (0, 1); when
  /// max_iterations end it before, the status is budget_exhausted. Without one exactly max_iterations are drawn.
  std::optional<double> confidence = 0.999;
  /// Only samples whose pairwise lengths differ by less than this many noise bounds between the clouds are fitted; > 0,
  /// infinity: all are. From 2 on no sample of inliers fails, by the triangle inequality. More lets near misses pass,
  /// which local optimisation often brings home.
  double length_tolerance = 6.0;
  /// Refit the poses of promising samples to their supporters (LO-RANSAC: O. Chum, J. Matas, J. Kittler, "Locally
  /// Optimized RANSAC", DAGM 2003). Samples that the best pose explains lead to it again and are not fitted then.
  bool local_optimisation = true;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Registers with three-point RANSAC: the pose of a random sample with the largest truncated quadratic score (MSAC) on
/// all correspondences, then the refinement and the tests of the default solver. Parallel over samples in the caller's
/// oneTBB arena; the result has the same bits for any number of threads and every ISA. Throws std::invalid_argument on
/// a bad option.
[[nodiscard]] Registration register_ransac(const Correspondences& correspondences, const RansacOptions& options);

}  // namespace consimd
