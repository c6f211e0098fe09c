// The options of turboreg.
#pragma once

#include <consimd/solvers/turboreg.hpp>

#include "call/option_list.hpp"
#include "search/matrix_sample.hpp"
#include "support/pose_ranking_names.hpp"

namespace consimd::detail {

inline const OptionList<TurboRegOptions>& turboreg_options() {
  static const OptionList<TurboRegOptions> list{
      option<&TurboRegOptions::length_tolerance>("length_tolerance", "noise bounds",
                                                 "correspondences are compatible when their lengths differ by less",
                                                 kPositive),
      option<&TurboRegOptions::separation>("separation", "noise bounds",
                                           "and add up to more: short pairs determine a pose badly", kPositive),
      option<&TurboRegOptions::pivots>("pivots", "edges", "of most common neighbours, which cliques are searched from",
                                       1),
      option<&TurboRegOptions::cliques_per_pivot>("cliques_per_pivot", "cliques", "kept of each pivot", 1),
      option<&TurboRegOptions::ranking>("ranking", "", "the support that ranks the cliques' poses"),
      option<&TurboRegOptions::matrix_budget_bytes>(
          "matrix_budget_bytes", "bytes",
          "memory for the compatibility matrix; of more correspondences than fit, the graph is that of a random sample",
          least_matrix_budget(1)),
  };
  return list;
}

}  // namespace consimd::detail
