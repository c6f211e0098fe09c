// The options of teaser.
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include <consimd/solvers/teaser.hpp>

#include "call/option_list.hpp"

namespace consimd::detail {

template <>
struct OptionNames<TeaserOptions::Selection> {
  using Pair = std::pair<std::string_view, TeaserOptions::Selection>;
  static constexpr std::array kAll{Pair("maximum_clique", TeaserOptions::Selection::maximum_clique),
                                   Pair("maximum_core", TeaserOptions::Selection::maximum_core),
                                   Pair("everything", TeaserOptions::Selection::everything)};
};

template <>
struct OptionNames<GncRotationOptions::Pairs> {
  using Pair = std::pair<std::string_view, GncRotationOptions::Pairs>;
  static constexpr std::array kAll{Pair("chain", GncRotationOptions::Pairs::chain),
                                   Pair("all", GncRotationOptions::Pairs::all)};
};

inline const OptionList<TeaserOptions>& teaser_options() {
  static const OptionList<TeaserOptions> list{
      option<&TeaserOptions::estimate_scale>("estimate_scale", "",
                                             "find the scale of the source as well; needs a noise bound and no filter"),
      option<&TeaserOptions::selection>("selection", "",
                                        "the correspondences that go on, of the graph of pairs that agree in length"),
      option<&TeaserOptions::max_nodes>("max_nodes", "nodes",
                                        "of the clique search, at most; when they end before the proof, and another "
                                        "pose may be as good, the status is budget_exhausted; 0: greedy alone"),
      option<&TeaserOptions::max_work>("max_work", "words",
                                       "of rows of the graph that the clique search combines, at most, about a "
                                       "nanosecond each; when they end, as with max_nodes",
                                       1),
      option<&TeaserOptions::rotation_pairs>(
          "rotation_pairs", "", "the differences that give the rotation: each member with the next, or all pairs"),
      option<&TeaserOptions::refine>(
          "refine", "",
          "bring the pose to the statistical limit with all correspondences; false: the paper's votes, no covariance"),
      option<&TeaserOptions::matrix_budget_bytes>("matrix_budget_bytes", "bytes",
                                                  "memory for the graph; one that needs more is an error"),
  };
  return list;
}

}  // namespace consimd::detail
