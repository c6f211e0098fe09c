// MAC's node-guided selection: for each vertex the heaviest maximal clique that holds it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/solvers/mac.hpp>

#include "mac/compatibility_graph.hpp"

namespace consimd::detail {

struct WeightedClique {
  std::vector<std::uint32_t> rows;  ///< ascending
  float weight = 0.0F;              ///< sum over its edges
};

struct SelectedCliques {
  std::vector<WeightedClique> cliques;   ///< all different, heaviest first
  std::uint64_t found = 0;               ///< maximal cliques met
  std::vector<std::uint32_t> cut_short;  ///< vertices whose share of a budget ended
  bool stopped = false;                  ///< before all vertices had their turn
};

/// Selects among the maximal cliques of three and more. Parallel over vertices.
SelectedCliques select_cliques(const CompatibilityGraph& graph, const MacOptions& options);

}  // namespace consimd::detail
