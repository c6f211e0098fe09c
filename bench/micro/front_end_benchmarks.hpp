// Registers benchmarks of the kernels that correspondences are made of from two clouds; single thread.
#pragma once

namespace consimd::bench {

/// Each KERNEL/N/ISA, held against the scalar reference bit for bit first; the clouds are samples of a made-up street
/// of N points, neighbourhoods have some 70 points. neighbours_within: an item a neighbour, the walk through the cells
/// included; neighbourhood_scatter: an item a neighbour; principal_axes: an item a matrix; pair_feature_counts: an item
/// a pair; weighted_histogram_sum: an item a histogram; best_matches: mutual best three of N FPFH descriptors, an item
/// a distance.
void register_front_end_benchmarks();

}  // namespace consimd::bench
