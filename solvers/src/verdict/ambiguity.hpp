// When is another motion as good an answer?
#pragma once

#include <cstddef>
#include <cstdint>

namespace consimd::detail {

/// Share of the best pose's support from which another motion makes the result ambiguous.
inline constexpr double kRivalShare = 0.8;

/// Whether a pose with so many supporters might be the true one as well as the best.
constexpr bool is_rival(std::size_t support, std::size_t best_support) {
  return static_cast<double>(support) >= kRivalShare * static_cast<double>(best_support);
}

}  // namespace consimd::detail
