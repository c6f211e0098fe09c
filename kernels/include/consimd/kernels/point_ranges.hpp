// Points in a range of structs or small arrays, as they are: no copy.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <ranges>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// A struct with data members x, y and z of one type, float or double, whatever else it has.
template <typename P>
concept PointStruct = requires(const P& p) {
  requires std::floating_point<std::remove_cvref_t<decltype(p.x)>>;
  requires std::same_as<decltype(P::x), decltype(P::y)> && std::same_as<decltype(P::x), decltype(P::z)>;
};

/// Three coordinates or more side by side in the point itself: std::array<float, 3>, double[3], Eigen::Vector3d.
template <typename P>
concept PointArray = !PointStruct<P> && !std::is_pointer_v<P> && !std::ranges::view<P> &&
                     std::is_trivially_destructible_v<P> && requires(const P& p) {
  requires std::is_lvalue_reference_v<decltype(p[0])>;
  requires std::floating_point<std::remove_cvref_t<decltype(p[0])>>;
};

/// The points of a contiguous range: std::vector or std::span of any `PointStruct` (pcl::PointXYZ, 16 bytes; a point
/// with normal, colour, time) or `PointArray`. The range must outlive the result; a temporary that owns its points does
/// not compile. Throws std::invalid_argument where x, y and z are not evenly spaced.
template <typename Range>
requires std::ranges::contiguous_range<Range> && std::ranges::borrowed_range<Range> &&
    (PointStruct<std::ranges::range_value_t<Range>> || PointArray<std::ranges::range_value_t<Range>>)
        [[nodiscard]] auto range_points(Range&& points) {
  using Point = std::ranges::range_value_t<Range>;
  const auto coordinates = [](const Point& p) {
    if constexpr (PointStruct<Point>) {
      return std::array{&p.x, &p.y, &p.z};
    } else {
      return std::array{&p[0], &p[1], &p[2]};
    }
  };
  using T = std::remove_cvref_t<decltype(*coordinates(std::declval<const Point&>())[0])>;
  static_assert(std::same_as<T, float> || std::same_as<T, double>, "coordinates are float or double");
  static_assert(sizeof(Point) % sizeof(T) == 0 && alignof(Point) >= alignof(T),
                "the points are packed so that their coordinates are not aligned: copy them");
  if constexpr (PointArray<Point>) static_assert(sizeof(Point) >= 3 * sizeof(T), "points of at least 3 coordinates");

  PointSpan<T> span{nullptr, std::ranges::size(points), static_cast<std::ptrdiff_t>(sizeof(Point) / sizeof(T)), 1};
  if (span.size == 0) return span;
  const auto [x, y, z] = coordinates(*std::ranges::data(points));
  span.data = x;
  span.coordinate_stride = y - x;
  if (z - y != y - x) {
    throw std::invalid_argument("the x, y and z of a point are not evenly spaced: y is " + std::to_string(y - x) +
                                " elements after x, z " + std::to_string(z - y) + " after y");
  }
  return span;
}

}  // namespace consimd
