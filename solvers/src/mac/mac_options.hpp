// The options of mac.
#pragma once

#include <consimd/solvers/mac.hpp>

#include "call/option_list.hpp"

namespace consimd::detail {

inline const OptionList<MacOptions>& mac_options() {
  static const OptionList<MacOptions> list{
      option<&MacOptions::compatibility_distance>(
          "compatibility_distance", "noise bounds",
          "d: pairs whose lengths differ by delta have the score 1 - delta^2 / d^2", kPositive),
      option<&MacOptions::compatibility_threshold>("compatibility_threshold", "score",
                                                   "pairs with a score above it are edges",
                                                   RealRange{.least = 0.0, .most = 1.0, .least_included = true}),
      option<&MacOptions::second_order>(
          "second_order", "", "weigh edges by the score times the number of correspondences compatible with both ends"),
      option<&MacOptions::max_mean_degree>("max_mean_degree", "edges a vertex",
                                           "a graph with more is thinned out to so many; inf: never",
                                           kPositiveOrInfinite),
      option<&MacOptions::max_cliques>("max_cliques", "cliques", "of three and more, at most", 1),
      option<&MacOptions::max_nodes>("max_nodes", "nodes", "of the clique search, at most", 1),
      option<&MacOptions::max_hypotheses>("max_hypotheses", "cliques",
                                          "of the heaviest that poses are made of, at most", 1),
      option<&MacOptions::weighted_fit>(
          "weighted_fit", "", "weigh a clique's correspondences by the leading eigenvector of its edge weights"),
      option<&MacOptions::matrix_budget_bytes>("matrix_budget_bytes", "bytes",
                                               "memory for the graph; one that needs more is an error"),
  };
  return list;
}

}  // namespace consimd::detail
