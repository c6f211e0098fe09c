// The maximum clique of a graph: the largest set of correspondences that all agree with one another.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/solvers/bit_graph.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

struct MaximumCliqueOptions {
  /// Nodes of the search tree, at most; when they end before the proof, the best clique so far is given. 0: the greedy
  /// heuristic alone. Nodes, not seconds: the result is the same on every machine.
  std::uint64_t max_nodes = 200'000;
  /// Work of greedy heuristic and search, at most: rows of the graph that are combined, each counted as its 64-bit
  /// words and 32 more. A nanosecond or so a unit: what bounds the time where a graph is large and dense. Checked now
  /// and then, so there may be somewhat more; when it ends, as above.
  std::uint64_t max_work = std::uint64_t{1} << 31;
  /// Cliques of up to so many vertices are of no interest, which saves most of the work where there are no larger ones.
  std::uint32_t larger_than = 0;
  StopCondition stop = {};  ///< ends the search as a budget does
};

struct MaximumClique {
  std::vector<std::uint32_t> members;  ///< ascending; empty: none larger than `larger_than` was found
  bool proven = false;                 ///< no larger clique exists
  std::uint64_t nodes = 0;             ///< of the search tree
  std::uint64_t work = 0;              ///< as in MaximumCliqueOptions
};

/// Exact branch and bound. Greedy cliques from every vertex give the first bound; vertices whose core number is below
/// it go, and those that miss at most one other are settled without search, which is most of a dense graph. The rest is
/// searched vertex by vertex in degeneracy order with greedy colouring as the bound, on bits (P. San Segundo et al.,
/// "An exact bit-parallel algorithm for the maximum clique problem", Computers & Operations Research 38, 2011, after E.
/// Tomita's MCS; the order by vertices as in R. Rossi et al., "Fast maximum clique algorithms for large graphs", WWW
/// 2014). Parallel over vertices in the caller's oneTBB arena; the same result for any number of threads and every ISA.
/// Holds at most two more copies of the graph.
[[nodiscard]] MaximumClique maximum_clique(const GraphView& graph, const MaximumCliqueOptions& options = {});

}  // namespace consimd
