// Cells of space as numbers that sort and hash.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "support/points.hpp"

namespace consimd::detail {

/// The cell of a lattice of this edge that the point lies in, as one number. Cells are told apart as far as 2^20 of
/// them from the origin; what is further out is in those at the border, and so are far rows, which are not a number.
inline std::uint64_t cell_key(const Point& p, double edge) {
  constexpr double kHalf = 1U << 20U;
  const auto index = [edge](float x) {
    return static_cast<std::uint64_t>(std::min(kHalf - 1.0, std::max(-kHalf, std::floor(x / edge))) + kHalf);
  };
  return index(p.x) | index(p.y) << 21U | index(p.z) << 42U;
}

}  // namespace consimd::detail
