// The table of functions for one architecture.
#pragma once

#include "alignment_residuals-inl.hpp"
#include "angle_consistency-inl.hpp"
#include "clouds/cloud_kernels-inl.hpp"
#include "consensus-inl.hpp"
#include "consistency_matrix-inl.hpp"
#include "kernel_table.hpp"
#include "length_consistency-inl.hpp"
#include "length_ratio-inl.hpp"
#include "rigid_moments-inl.hpp"
#include "three_point_fit-inl.hpp"

namespace consimd::detail {

/// The count-only form of run_consensus.
template <typename Arch, typename Test, typename Hypothesis>
void count_consensus(const RawView& view, const Hypothesis* hypotheses, std::size_t n, float bound,
                     std::uint32_t* counts) {
  run_consensus<Arch, Test>(view, hypotheses, n, bound, nullptr, counts);
}

template <typename Arch>
inline constexpr KernelTable kTable{
    .length_counts = count_consensus<Arch, LengthTest<Arch>, std::uint32_t>,
    .length_bits = run_consensus<Arch, LengthTest<Arch>, std::uint32_t>,
    .angle_counts = count_consensus<Arch, AngleTest<Arch>, IndexPair>,
    .angle_bits = run_consensus<Arch, AngleTest<Arch>, IndexPair>,
    .alignment_counts = count_consensus<Arch, AlignmentTest<Arch>, WorkingPose>,
    .alignment_scores = alignment_scores<Arch>,
    .alignment_bits = run_consensus<Arch, AlignmentTest<Arch>, WorkingPose>,
    .alignment_residuals = alignment_residuals<Arch>,
    .weighted_moments = weighted_moments<Arch>,
    .subset_moments = subset_moments<Arch>,
    .robust_moments = robust_moments<Arch>,
    .three_point_fits = three_point_fits<Arch>,
    .consistency_matrix = consistency_matrix<Arch, LengthTest<Arch>, float>,
    .separated_matrix = consistency_matrix<Arch, SeparatedLengthTest<Arch>, SeparatedBounds>,
    .ratio_matrix = consistency_matrix<Arch, LengthRatioTest<Arch>, RatioBounds>,
    .and_popcount = and_popcount<Arch>,
    .and_popcount_rows = and_popcount_rows<Arch>,
    .masked_row_sums = masked_row_sums<Arch>,
    .length_disagreement = length_disagreement<Arch>,
    .scale_intervals = scale_intervals<Arch>,
    .clouds = kCloudKernels<Arch>,
};

}  // namespace consimd::detail
