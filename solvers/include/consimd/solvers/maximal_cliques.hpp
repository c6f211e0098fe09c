// All maximal cliques of a graph: sets of correspondences that agree pairwise and that no other agrees with entirely.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/solvers/bit_graph.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

/// A graph of N vertices can have 3^(N/3) maximal cliques, so both budgets are split evenly over the vertices: each
/// spends its share on the cliques that it is the first of in a degeneracy order.
struct MaximalCliqueOptions {
  std::uint32_t min_size = 1;  ///< smaller ones are left out
  std::uint64_t max_cliques = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t max_nodes = std::numeric_limits<std::uint64_t>::max();  ///< of the search tree
  StopCondition stop = {};                                              ///< ends the search as a budget does
};

struct MaximalCliques {
  std::vector<std::vector<std::uint32_t>> cliques;  ///< each ascending, in no particular order
  std::uint64_t nodes = 0;
  std::vector<std::uint32_t>
      cut_short;  ///< vertices whose share of a budget ended, ascending; empty: all cliques found
};

/// Bron-Kerbosch with Tomita's pivot, vertex by vertex in degeneracy order, on bits (D. Eppstein, M. Löffler, D.
/// Strash, "Listing All Maximal Cliques in Large Sparse Real-World Graphs", 2013). Vertices with many common neighbours
/// are tried first, so that a budget that ends has been spent on the dense parts.
[[nodiscard]] MaximalCliques maximal_cliques(const GraphView& graph, const MaximalCliqueOptions& options = {});

}  // namespace consimd
