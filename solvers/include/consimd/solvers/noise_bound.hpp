// The noise bound, when nobody knows it.
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

struct NoiseBoundEstimate {
  double noise_bound = 0.0;  ///< caller's unit; three times the estimated deviation per axis of inliers' residuals
  double log10_false_poses = 0.0;  ///< of the pose that the estimate rests on, all bounds tried taken into account
  std::uint32_t bounds_tried = 1;
};

/// Searches poses at noise bounds that halve from a quarter of the extent of the sources to a 2000th, keeps the one
/// whose support is least likely by chance (the choice of scale in a-contrario RANSAC, Moisan & Stival 2004), and
/// measures the residuals around it, less what six parameters take from them. Some of the rows do where these put a
/// pose beyond doubt. Where no pose is significant the bound is that of the least insignificant one, and a registration
/// with it will say so. An empty input, or one of coincident points, gives a bound of 1.
///
/// Takes some milliseconds up to tens of them, whatever solver is called next: docs/statistical_model.md, "Noise
/// bound", has the times. The same bits for any number of threads and every ISA.
[[nodiscard]] NoiseBoundEstimate estimate_noise_bound(const Correspondences& correspondences, std::uint64_t seed);

}  // namespace consimd
