// What a scan tells of space: where its surfaces are, and what it saw through.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/cloud.hpp>

namespace consimd::features::detail {

using Vector3 = std::array<double, 3>;

[[nodiscard]] inline Eigen::Vector3d vector(const Vector3& x) { return {x[0], x[1], x[2]}; }

[[nodiscard]] inline double dot(const Vector3& a, const Vector3& b) noexcept {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A point of a surface in the caller's frame, with its unit normal.
struct SurfacePoint {
  Vector3 point{};
  Vector3 normal{};
  bool has_front = false;  ///< the normal points to the side that was seen
};

/// Whether they face one way but for 45 degrees: normals of thinned out clouds are some 10 to 20 degrees off at edges.
/// Either side where not both are known to show their front.
[[nodiscard]] inline bool of_like_orientation(const SurfacePoint& a, const SurfacePoint& b) noexcept {
  constexpr double kCosine = 0.7071067811865476;
  const double cosine = dot(a.normal, b.normal);
  return (a.has_front && b.has_front ? cosine : std::abs(cosine)) >= kCosine;
}

/// What is near a place.
enum class Agreement : std::uint8_t {
  surface,  ///< a surface of like orientation passes there
  other,    ///< only one of another orientation, or one that passes beside
  empty,    ///< nothing
};

/// The surfaces of a cloud in a hash table of cubes: each cube knows the surface point nearest to its centre.
class SurfaceMap {
 public:
  /// voxel: what the points were thinned out to, caller's unit; sides: of a cube, in voxels. Throws
  /// std::invalid_argument where they are more than 2^20 voxels apart.
  SurfaceMap(std::vector<SurfacePoint> points, double voxel, double sides = 1.0);

  /// The points, as they were given.
  [[nodiscard]] std::span<const SurfacePoint> surfaces() const noexcept { return points_; }
  [[nodiscard]] Agreement agreement(const SurfacePoint& place) const noexcept;
  /// Tells the same of many places, faster, since their waits for memory overlap. found: as many as places.
  void agreements(std::span<const SurfacePoint> places, std::span<Agreement> found) const noexcept;
  /// The surface that the place agrees with, or null.
  [[nodiscard]] const SurfacePoint* surface_at(const SurfacePoint& place) const noexcept;
  /// Square of the distance to the plane of that surface, in sides of a cube; 1 where there is none.
  [[nodiscard]] double squared_distance(const SurfacePoint& place) const noexcept;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Cube {
    std::uint64_t key = 0;
    std::uint32_t point = kNone;
    float squared_distance = 0.0f;
  };

  /// A cube that a surface point reaches.
  struct Reached {
    std::uint64_t key;
    std::uint64_t hash;
    std::uint32_t point;
    float squared_distance;
  };
  static constexpr std::size_t kMostReached = 20;  // centres of cubes within 1.5 sides of a point, at most
  /// Lists those of point i, kMostReached at most, and asks for the memory of their entries; returns how many there
  /// are.
  std::size_t list_reached(std::uint32_t i, std::span<Reached> reached) const noexcept;
  /// Gives the cube its nearest point; returns whether it had none before.
  bool enter(const Reached& cube) noexcept;
  void grow();
  [[nodiscard]] std::uint32_t find(const Vector3& place) const noexcept;
  /// The key of the cube that the place is in; none outside of the cubes that surfaces reach.
  [[nodiscard]] std::optional<std::uint64_t> key_of(const Vector3& place) const noexcept;
  [[nodiscard]] bool may_hold(std::uint64_t hash) const noexcept;
  /// The point of the cube of this key, looked for from entry `at` of the table on.
  [[nodiscard]] std::uint32_t point_of(std::uint64_t key, std::uint64_t at) const noexcept;
  [[nodiscard]] static double offset(const SurfacePoint& surface, const SurfacePoint& place) noexcept;
  [[nodiscard]] bool passes(const SurfacePoint& surface, const SurfacePoint& place) const noexcept;
  [[nodiscard]] Cube& slot(std::uint64_t key, std::uint64_t hash) noexcept;
  void fill_filter();

  Vector3 low_{};
  double per_side_;
  double side_;
  std::array<std::int64_t, 3> cubes_{};
  std::vector<SurfacePoint> points_;
  std::vector<Cube> table_;
  std::uint64_t mask_ = 0;
  // A bit for each cube, by other bits of the hash: most places are in none, which this tells from near memory.
  std::vector<std::uint64_t> filter_;
};

/// The range to which a scan saw, by direction: the six faces of a cube around the viewpoint, each of the same number
/// of cells.
class FreeSpace {
 public:
  FreeSpace() = default;
  /// margin: what is nearer than this to what was seen is not free, caller's unit. Of a scan that was not taken from
  /// there, where much of it lies behind the rest, nothing is known.
  FreeSpace(const Cloud& scan, const Vector3& viewpoint, double margin);

  /// Where the scan was taken from; nothing where nothing is known.
  [[nodiscard]] std::optional<Vector3> viewpoint() const noexcept {
    return edge_ > 0 ? std::optional(viewpoint_) : std::nullopt;
  }
  /// Whether a point of the scan lies behind others of it by no more than the margin.
  [[nodiscard]] bool sees(const Vector3& point) const noexcept;

  /// How many of the places the scan saw through: only what is farther away in their directions and those next to them.
  [[nodiscard]] std::uint32_t count_seen_through(std::span<const SurfacePoint> places) const noexcept;

 private:
  struct Direction {
    std::size_t cell = 0;
    double squared_range = 0.0;
  };
  [[nodiscard]] Direction direction(const Vector3& place) const noexcept;
  /// Fills the ranges. points: where the scan saw.
  void look(const std::vector<Direction>& points);
  [[nodiscard]] bool hides_much(const std::vector<Direction>& points) const;
  void reach_to_the_nearest_beside();

  Vector3 viewpoint_{};
  double margin_ = 0.0;
  std::size_t edge_ = 0;      // cells along an edge of a face; 0: nothing is known
  std::vector<float> range_;  // of the nearest point in a cell and those next to it; 0 where a cell is empty
};

/// The points of a cloud that have a normal. Where it is known what was seen from where, the normals are turned to the
/// viewpoint; a point has a front if it was seen from there, and not along the surface.
[[nodiscard]] std::vector<SurfacePoint> surface_points(const CellGrid& surfaces, const FreeSpace& space);

}  // namespace consimd::features::detail
