// Registers the benchmarks of the graph stages: cliques, cores, edges, second-order sets.
#pragma once

namespace consimd::bench {

/// Named graph/stage/outliers:RATIO/variant, problems of the noise study with 3000 correspondences and sigma 1 m; a
/// variant is "scalar" or the active instruction set. Each checks what it found, and that it is what the scalar
/// reference finds, before it is timed: CPU time on one thread.
void register_graph_benchmarks();

}  // namespace consimd::bench
