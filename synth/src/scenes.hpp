// Points of the scenes of hard problems, and points that look like them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <consimd/synth/hard_problems.hpp>

#include "random_stream.hpp"

namespace consimd::synth {

/// Two scenes of a kind, before their turn: that of the sources, and the other of OutlierModel::alike.
class ScenePair {
 public:
  struct Point {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::uint32_t part = 0;  ///< the ring, line, corner of a window or face that it is on
  };

  /// `layout`: where the places of poles and lines are drawn from.
  ScenePair(const HardProblemOptions& options, RandomStream& layout);

  /// A random point of the first scene.
  [[nodiscard]] Point point(RandomStream& random) const;

  /// A random point of the second scene among those that look like that one of the first.
  [[nodiscard]] Eigen::Vector3d alike(const Point& point, RandomStream& random) const;

  /// Mean square distance of the first scene's points from the origin.
  [[nodiscard]] double mean_square_range() const;

 private:
  struct Segment {
    Eigen::Vector3d from, to;
  };

  [[nodiscard]] bool has_faces() const;
  [[nodiscard]] double ring_radius(std::uint32_t ring) const;
  /// The coordinate of the k-th of `count` evenly spaced places in [-half_extent, half_extent].
  [[nodiscard]] double place(std::uint32_t k, std::uint32_t count) const;
  [[nodiscard]] Eigen::Vector3d on_ring(std::uint32_t ring, RandomStream& random) const;
  [[nodiscard]] Eigen::Vector3d on_face(std::uint32_t face, RandomStream& random) const;
  [[nodiscard]] Eigen::Vector3d at_any_window(std::uint32_t corner, RandomStream& random) const;
  [[nodiscard]] std::uint32_t random_face(RandomStream& random) const;
  [[nodiscard]] std::uint32_t window_rows() const;
  [[nodiscard]] Eigen::Vector3d window_corner(std::uint32_t corner) const;

  Scene scene_;
  double half_extent_;
  std::uint32_t parts_;
  Eigen::Vector3d box_;                     ///< half extents of the slab, the rod, the corridor and so on
  std::array<double, 3> areas_{};           ///< of the pairs of faces across each axis, those that are there
  std::vector<Segment> segments_, others_;  ///< poles or lines of the first and the second scene
};

}  // namespace consimd::synth
