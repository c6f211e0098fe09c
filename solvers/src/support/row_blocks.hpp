// Kernels over all rows of a problem. Where rows are many, blocks of them are worked on in parallel.
#pragma once

#include <cstdint>
#include <span>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail::row_blocks {

// As the kernels of the same name, with sums taken block by block, in order: the same bits for any number of threads. A
// caller may hold thread-local scratch: a thread that waits for its blocks takes no other work.

void alignment_scores(const CorrespondenceView& view, std::span<const WorkingPose> poses, double bound,
                      std::span<PoseSupport> support);
/// Those of one pose; returns their number.
std::uint32_t alignment_bits(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                             std::span<std::uint64_t> bits);
[[nodiscard]] std::uint32_t alignment_count(const CorrespondenceView& view, const WorkingPose& pose, double bound);
void mismatched_counts(const CorrespondenceView& view, const WorkingPose& pose, double bound,
                       std::span<const std::uint32_t> shifts, std::span<std::uint32_t> counts);
[[nodiscard]] RigidMoments robust_moments(const CorrespondenceView& view, const WorkingPose& pose,
                                          const RobustWeight& weight);

/// The least-squares pose of the rows within `bound` of `pose`.
[[nodiscard]] RigidFit truncated_fit(const CorrespondenceView& view, const WorkingPose& pose, double bound);

}  // namespace consimd::detail::row_blocks
