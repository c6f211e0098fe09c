// Weighted moments of correspondences: all that a weighted least-squares rigid fit (Kabsch, Horn) needs.
#pragma once

#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// Moments with the given weights. weights: view.padded_size() floats, 64-byte aligned; those of padded lanes may be
/// anything. Throws std::invalid_argument on other sizes and alignments. Far rows (see Correspondences) make them NaN,
/// whatever their weight: leave these out by a subset. Single-precision products in 16 interleaved single-precision
/// sums, joined in double after every 1024 correspondences, all in one fixed order: the same bits on every ISA.
/// Relative rounding about 1e-7 of the sum of the absolute terms.
[[nodiscard]] RigidMoments weighted_moments(const CorrespondenceView& view, std::span<const float> weights);

/// Moments over the correspondences whose bit is set, each with weight 1, in the working frame; `residual` is 0. bits:
/// view.words() words, whose bits from view.size() on are 0, as kernels leave them; a far row whose bit is set makes
/// the moments NaN. The same sums as above. Throws std::invalid_argument on another number of words.
[[nodiscard]] RigidMoments subset_moments(const CorrespondenceView& view, std::span<const std::uint64_t> bits);

/// One pass of an iteratively reweighted fit: residuals under `pose`, weights from them, moments from these. `pose` and
/// the moments are in the working frame, so is a pose fitted to them; scale and cutoff of `weight` are in the caller's
/// unit. Far rows, and all rows under a pose with a NaN, have no weight. Throws std::invalid_argument on a scale or
/// cutoff that is not finite and > 0, odds that are not finite and >= 0, or an exponent that is no power of two from 2
/// to 64, whatever the function is.
[[nodiscard]] RigidMoments robust_moments(const CorrespondenceView& view, const WorkingPose& pose,
                                          const RobustWeight& weight);

}  // namespace consimd
