// The box around a cloud.
#pragma once

#include <array>

#include <consimd/kernels/cloud.hpp>

namespace consimd::features::detail {

/// Lowest and highest coordinates, working frame.
struct Box {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
};

/// The smallest that holds all points; that of an empty cloud is at the origin, without extent.
[[nodiscard]] Box box_around(const Cloud& cloud);

/// Its longest side, caller's unit.
[[nodiscard]] double extent(const Cloud& cloud);

}  // namespace consimd::features::detail
