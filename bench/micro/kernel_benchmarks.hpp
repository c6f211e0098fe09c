// Registers the benchmarks of every kernel: instruction sets and baselines, by number of correspondences.
#pragma once

namespace consimd::bench {

/// Named kernel/correspondences/variant; a variant is an instruction set, "loop", "textbook" or "eigen". Each checks
/// its result against the scalar reference before it is timed.
void register_kernel_benchmarks();

}  // namespace consimd::bench
