// Registers benchmarks of nearest neighbours and of the refinement of a pose, single thread.
#pragma once

namespace consimd::bench {

/// nearest_within/N/ISA: the nearest two of a cloud's points around places beside it, an item a query, held against the
/// scalar reference first; refine/METHOD/N: N source points to as many target points, all steps, the target's cells
/// made anew. The clouds are samples of a made-up street, whatever N is of the same area.
void register_refinement_benchmarks();

}  // namespace consimd::bench
