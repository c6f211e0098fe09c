// The names of the supports that rank poses, as options.
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include <consimd/solvers/pose_ranking.hpp>

#include "call/option_list.hpp"

namespace consimd::detail {

template <>
struct OptionNames<PoseRanking> {
  using Pair = std::pair<std::string_view, PoseRanking>;
  static constexpr std::array kAll{Pair("inlier_count", PoseRanking::inlier_count),
                                   Pair("truncated_score", PoseRanking::truncated_score)};
};

}  // namespace consimd::detail
