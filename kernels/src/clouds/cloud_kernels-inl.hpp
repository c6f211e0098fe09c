// The kernels on clouds and descriptors of one architecture.
#pragma once

#include "cloud_kernels.hpp"
#include "descriptor_matches-inl.hpp"
#include "neighbourhoods-inl.hpp"
#include "pair_equations-inl.hpp"
#include "pair_features-inl.hpp"

namespace consimd::detail {

template <typename Arch>
inline constexpr CloudKernels kCloudKernels{
    .neighbours_within = neighbours_within<Arch>,
    .nearest_within = nearest_within<Arch>,
    .neighbourhood_scatter = neighbourhood_scatter<Arch>,
    .principal_axes = principal_axes<Arch>,
    .pair_feature_counts = pair_feature_counts<Arch>,
    .weighted_histogram_sum = weighted_histogram_sum<Arch>,
    .best_matches = best_matches<Arch>,
    .move_pairs = move_pairs<Arch>,
    .pair_residuals = pair_residuals<Arch>,
    .pair_equations = pair_equations<Arch>,
};

}  // namespace consimd::detail
