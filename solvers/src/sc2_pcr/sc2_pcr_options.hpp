// The options of sc2_pcr.
#pragma once

#include <consimd/solvers/sc2_pcr.hpp>

#include "call/option_list.hpp"
#include "search/matrix_sample.hpp"
#include "support/pose_ranking_names.hpp"

namespace consimd::detail {

inline const OptionList<Sc2PcrOptions>& sc2_pcr_options() {
  static constexpr WholeRange kSetSize{3, 64};
  static const OptionList<Sc2PcrOptions> list{
      option<&Sc2PcrOptions::length_tolerance>(
          "length_tolerance", "noise bounds",
          "correspondences are compatible when their lengths differ by less; common neighbours count with half of it",
          kPositive),
      option<&Sc2PcrOptions::seed_radius>(
          "seed_radius", "noise bounds",
          "only the most confident of the correspondences whose sources are within it is a seed", kPositive),
      option<&Sc2PcrOptions::seed_share>(
          "seed_share", "share",
          "of the correspondences that are seeds; if these lead to no significant pose, the others follow", kShare),
      option<&Sc2PcrOptions::power_iterations>(
          "power_iterations", "rounds",
          "of the power iteration for the confidence of correspondences, and for the weights within a set", 1),
      option<&Sc2PcrOptions::first_set>("first_set", "members", "of a seed's first consensus set, the seed included",
                                        kSetSize),
      option<&Sc2PcrOptions::second_set>("second_set", "members", "of its second consensus set; no more than first_set",
                                         kSetSize),
      option<&Sc2PcrOptions::ranking>("ranking", "", "the support that ranks the seeds' poses"),
      option<&Sc2PcrOptions::matrix_budget_bytes>("matrix_budget_bytes", "bytes",
                                                  "memory for the two compatibility matrices; of more correspondences "
                                                  "than fit, they are those of a random sample",
                                                  least_matrix_budget(2)),
  };
  return list;
}

}  // namespace consimd::detail
