// Registers benchmarks of what is done with clouds: nearest neighbours, the refinement of a pose and its kernels, and
// subsets of points; single thread.
#pragma once

namespace consimd::bench {

/// nearest_within/N/ISA: the nearest two of a cloud's points around places beside it, an item a query, held against the
/// scalar reference first; refine/METHOD/N: N source points to as many target points, all steps, the target's cells
/// made anew; move_pairs/N/ISA, pair_residuals/METRIC/N/ISA and pair_equations/METRIC/N/ISA: the kernels of a step, an
/// item a pair, held against the scalar reference bit for bit; farthest_subset/N: a third of N points, an item a chosen
/// point, and farthest_subset/N/loop, each distance to each chosen point, whose choice it must be. The clouds are
/// samples of a made-up street, whatever N is of the same area.
void register_cloud_benchmarks();

}  // namespace consimd::bench
