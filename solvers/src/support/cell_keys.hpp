// Cells of space as numbers that sort and hash.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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

/// The cells of a lattice that have all points within half their edge of p: first its own, then, along each axis, the
/// one that it is nearer to. Cells 2^21 from one another share a key, which the distance of their points tells.
inline std::array<std::uint64_t, 8> cells_about(const Point& p, double cells_per_length) {
  constexpr std::uint64_t kMask = (1U << 21U) - 1U;
  constexpr unsigned kBits = 21;
  const double x[3] = {p.x * cells_per_length, p.y * cells_per_length, p.z * cells_per_length};
  std::array<std::array<std::uint64_t, 2>, 3> along{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto towards_zero = static_cast<std::int64_t>(x[axis]);  // without the call that a floor is before SSE4.1
    const std::int64_t own = towards_zero - (static_cast<double>(towards_zero) > x[axis] ? 1 : 0);
    const std::int64_t beside = x[axis] - static_cast<double>(own) < 0.5 ? own - 1 : own + 1;
    along[axis] = {(static_cast<std::uint64_t>(own) & kMask) << kBits * axis,
                   (static_cast<std::uint64_t>(beside) & kMask) << kBits * axis};
  }
  std::array<std::uint64_t, 8> keys{};
  for (std::size_t corner = 0; corner < keys.size(); ++corner) {
    keys[corner] = along[0][corner & 1U] | along[1][corner >> 1U & 1U] | along[2][corner >> 2U];
  }
  return keys;
}

/// A slot of a table of 2^n of them for the key of a cell.
inline std::size_t slot_of(std::uint64_t key, std::size_t slots) {
  const std::uint64_t mixed = key * 0x9E3779B97F4A7C15U;  // the upper half of a product depends on all bits
  return (mixed >> 32U) & (slots - 1);
}

}  // namespace consimd::detail
