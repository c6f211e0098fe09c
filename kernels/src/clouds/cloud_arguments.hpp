// Checks and conversions between the public functions on clouds and the kernel tables.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <consimd/kernels/cloud.hpp>

#include "cloud_kernels.hpp"

namespace consimd::detail {

inline RawPoints raw_points(const CloudView& cloud) noexcept {
  RawPoints raw{{cloud.points(0), cloud.points(1), cloud.points(2)}, {}, cloud.size()};
  if (cloud.has_normals()) {
    for (std::size_t axis = 0; axis < 3; ++axis) raw.normals[axis] = cloud.normals(axis);
  }
  return raw;
}

/// A length in the working frame, single precision, kept within what its square can be told in. Throws
/// std::invalid_argument unless it is finite and > 0.
inline float working_length(const CloudView& cloud, double length, std::string_view name) {
  if (!std::isfinite(length) || length <= 0.0) {
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(length) +
                                ", expected a finite length above 0");
  }
  return static_cast<float>(std::clamp(length * cloud.scale(), 1e-9, 16.0));
}

/// Throws std::out_of_range unless all indices are below `size`.
inline void require_points(std::span<const std::uint32_t> indices, std::size_t size) {
  std::uint32_t largest = 0;
  for (const std::uint32_t index : indices) largest = std::max(largest, index);
  if (indices.empty() || largest < size) return;
  throw std::out_of_range("point " + std::to_string(largest) + " of " + std::to_string(size));
}

}  // namespace consimd::detail
