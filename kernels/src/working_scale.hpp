// The unit of working frames.
#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace consimd::detail {

/// Power of two that brings `largest` into [0.5, 1). Throws std::invalid_argument where it is not finite.
inline double working_scale(double largest) {
  if (!std::isfinite(largest)) throw std::invalid_argument("the extent of the points is beyond double precision");
  if (largest == 0.0) return 1.0;
  constexpr int kSmallestExponent = -1000;  // keeps the scale itself finite
  return std::ldexp(1.0, -std::max(std::ilogb(largest) + 1, kSmallestExponent));
}

}  // namespace consimd::detail
