// What a status means, for people who see the word for the first time.
#pragma once

#include <string_view>

#include <consimd/solvers/registration.hpp>

namespace consimd::studies {

[[nodiscard]] constexpr std::string_view meaning(Status status) noexcept {
  switch (status) {
    case Status::success:
      return "a pose with significant support";
    case Status::too_few_correspondences:
      return "no pose: fewer than three usable correspondences";
    case Status::no_consensus:
      return "no pose: none has more support than chance gives";
    case Status::degenerate_geometry:
      return "no pose: its supporters coincide or lie on a line";
    case Status::ambiguous:
      return "a pose, but another motion has about as much support";
    case Status::budget_exhausted:
      return "the best pose until the iterations ended";
  }
  return "";
}

}  // namespace consimd::studies
