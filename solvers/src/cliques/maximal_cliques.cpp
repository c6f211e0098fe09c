#include <consimd/solvers/maximal_cliques.hpp>

#include <algorithm>

#include "cliques/clique_enumeration.hpp"

namespace consimd {

MaximalCliques maximal_cliques(const GraphView& graph, const MaximalCliqueOptions& options) {
  MaximalCliques result;
  const std::size_t size = graph.size();
  const std::vector<std::uint32_t> order = core_numbers(graph).order;
  std::vector<std::uint32_t> rank(size);
  for (std::uint32_t p = 0; p < size; ++p) rank[order[p]] = p;
  detail::CliqueEnumeration enumeration;
  for (std::uint32_t v = 0; v < size; ++v) {
    if (options.stop.met()) {
      result.cut_short.push_back(v);
      continue;
    }
    enumeration.run(graph, rank, v, {options.min_size, options.max_cliques / size, options.max_nodes / size},
                    [&](std::span<const std::uint32_t> clique) {
                      std::vector<std::uint32_t>& members = result.cliques.emplace_back();
                      for (const std::uint32_t i : clique) members.push_back(enumeration.vertices()[i]);
                      std::ranges::sort(members);
                    });
    result.nodes += enumeration.nodes();
    if (!enumeration.complete()) result.cut_short.push_back(v);
  }
  return result;
}

}  // namespace consimd
