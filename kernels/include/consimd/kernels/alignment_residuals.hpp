// Residuals of correspondences under rigid poses: the three-point consensus test of TCF, Eq. (trans-estimate-ransac-3).
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// Correspondence j supports a pose when r_j = | R p_j + t - q_j | < bound, tested as r^2 < bound^2.
/// `bound` is in the caller's unit, finite and > 0. A pose with a NaN entry has no support.

/// counts[h] = number of supporters of poses[h]. poses, counts: H.
/// Throws std::invalid_argument on mismatched sizes or a bad bound.
void alignment_counts(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<std::uint32_t> counts);

/// Counts and truncated scores (see PoseSupport), without a unit. poses, support: H. Throws as `alignment_counts`.
void alignment_scores(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<PoseSupport> support);

/// Counts and supporter bits: H rows of view.words() words, laid out as in `length_consistency_bits`. poses, counts: H;
/// bits: H * view.words(). Throws as `alignment_counts`.
void alignment_bits(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                    std::span<std::uint64_t> bits, std::span<std::uint32_t> counts);

/// squared[j] = r_j^2 in the working frame: divide by view.scale()^2 for the caller's unit. squared: view.words() *
/// kBlock floats; those from view.size() on become NaN. Throws std::invalid_argument on another size.
void alignment_residuals(const CorrespondenceView& view, const WorkingPose& pose, std::span<float> squared);

/// Support that a pose gets from mismatched pairs: counts[s] = number of j with | R p_j + t - q_k | < bound, k = j +
/// kBlock * shifts[s], over the j whose k exists up to whole blocks: mismatched_pairs(view, shifts[s]) of them. What
/// chance alone would give a pose of correspondences like these. shifts: S, each > 0; counts: S. Throws as
/// `alignment_counts`.
void mismatched_counts(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                       std::span<const std::uint32_t> shifts, std::span<std::uint32_t> counts);

/// Number of pairs that `mismatched_counts` tests for a shift; 0 when the shift leaves none.
[[nodiscard]] std::size_t mismatched_pairs(const CorrespondenceView& view, std::uint32_t shift) noexcept;

}  // namespace consimd
