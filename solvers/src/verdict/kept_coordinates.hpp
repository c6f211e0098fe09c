// What matchers keep of a place: coordinates of a source that its match shares.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>

#include "support/points.hpp"

namespace consimd::detail {

/// Positions along the axes of least, middle and greatest spread of the sources, distances from their viewpoint (see
/// kept_viewpoint) and from the centroid.
enum class Coordinate : std::uint8_t { least, middle, greatest, range, from_centroid };
inline constexpr std::size_t kCoordinates = 5;
constexpr std::size_t index_of(Coordinate c) { return static_cast<std::size_t>(c); }

/// Some of them.
struct Kept {
  std::array<Coordinate, 3> coordinates;
  std::size_t count;

  [[nodiscard]] constexpr std::span<const Coordinate> all() const { return std::span(coordinates).first(count); }
};
constexpr Kept kept(Coordinate a) { return {{a}, 1}; }
constexpr Kept kept(Coordinate a, Coordinate b) { return {{a, b}, 2}; }
constexpr Kept kept(Coordinate a, Coordinate b, Coordinate c) { return {{a, b, c}, 3}; }

/// Everything that matchers are known to keep, each alone and together: height, position along a wall or in a
/// corridor's cross-section, the range about a sensor, wherever it is, and the position itself.
inline constexpr std::array kKept{kept(Coordinate::from_centroid),
                                  kept(Coordinate::from_centroid, Coordinate::least),
                                  kept(Coordinate::least),
                                  kept(Coordinate::middle),
                                  kept(Coordinate::greatest),
                                  kept(Coordinate::range),
                                  kept(Coordinate::least, Coordinate::middle),
                                  kept(Coordinate::range, Coordinate::least),
                                  kept(Coordinate::range, Coordinate::middle),
                                  kept(Coordinate::range, Coordinate::greatest),
                                  kept(Coordinate::least, Coordinate::middle, Coordinate::greatest)};

/// The coordinates of points of the source frame.
class SourceCoordinates {
 public:
  /// Axes are those of every `step`-th source.
  SourceCoordinates(const Correspondences& correspondences, std::size_t step);

  /// Those of a point in the working frame, in its unit.
  [[nodiscard]] std::array<float, kCoordinates> operator()(const Point& point) const;

  /// Of the sources, in the working frame.
  [[nodiscard]] const Eigen::Vector3d& viewpoint() const { return viewpoint_; }

  /// The direction that `least`, `middle` or `greatest` is the position along.
  [[nodiscard]] Eigen::Vector3f axis(Coordinate c) const {
    return principal_.row(static_cast<Eigen::Index>(index_of(c))).cast<float>();
  }

 private:
  Eigen::Matrix3d principal_;  // the axes, row by row
  Eigen::Vector3d viewpoint_;
};

}  // namespace consimd::detail
