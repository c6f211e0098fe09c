// Registers the benchmarks of every kernel: instruction sets and baselines, by number of correspondences.
#pragma once

#include "bench_options.hpp"

namespace consimd::bench {

/// Named kernel/correspondences/variant, with another number of hypotheses at once than the default
/// kernel/correspondences/variant/batch:N; a variant is an instruction set, "loop", "textbook" or "eigen". Each checks
/// its result against the scalar reference before it is timed.
void register_kernel_benchmarks(const BenchOptions& options);

}  // namespace consimd::bench
