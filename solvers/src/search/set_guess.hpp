// What is expected of a seed's set before it is pruned.
#pragma once

#include <algorithm>
#include <cstdint>

#include "search/tcf_tuning.hpp"

namespace consimd::detail {

struct SetGuess {
  float clique = 0.0F;        ///< size of the largest clique through the seed
  std::uint32_t partner = 0;  ///< row that tells
};

/// Members that pruning must leave in a part of a set, if it must leave `wanted` in the whole: about its share.
inline std::uint32_t wanted_of_part(double share, std::uint32_t wanted, const TwoPointTuning& tuning) {
  return share < 1.0 ? std::max(static_cast<std::uint32_t>(tuning.slack * share * wanted), 3U) : wanted;
}

}  // namespace consimd::detail
