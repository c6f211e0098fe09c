// The scenes of the stand-ins: surfaces that keypoints lie on, and how places on them look.
#pragma once

#include <vector>

#include <consimd/synth/stand_ins.hpp>

#include "random_stream.hpp"

namespace consimd::synth {

/// Surfaces of one kind look alike.
enum class SurfaceKind : std::uint8_t { ground, wall, trunk, foliage, pole, furniture, ceiling, rail };

/// How a place looks to a descriptor: the kind of its surface and where on it it is, within a period that repeats.
struct Look {
  SurfaceKind kind;
  double across, up;  ///< [0, 1], distance from the middle of the period: left and right look alike
};

struct SurfacePoint {
  Eigen::Vector3d position;                ///< scene frame, metres, z up
  Eigen::Vector3d tangent, other, normal;  ///< orthonormal
};

/// A rectangle, the side of an upright cylinder, or a ball of foliage.
class Surface {
 public:
  /// The rectangle origin + a across + b up, 0 <= a, b <= 1. A period of 0 is the side's length.
  static Surface rectangle(SurfaceKind kind, const Eigen::Vector3d& origin, const Eigen::Vector3d& across,
                           const Eigen::Vector3d& up, double period_across, double period_up);
  static Surface cylinder(SurfaceKind kind, const Eigen::Vector3d& foot, double radius, double height);
  static Surface ball(SurfaceKind kind, const Eigen::Vector3d& centre, double radius);

  [[nodiscard]] double area() const;
  [[nodiscard]] SurfacePoint sample(RandomStream& random) const;
  /// How a point on or near the surface looks. Foliage looks the same everywhere.
  [[nodiscard]] Look look(const Eigen::Vector3d& position) const;

 private:
  enum class Shape : std::uint8_t { rectangle, cylinder, ball };

  Shape shape_;
  SurfaceKind kind_;
  Eigen::Vector3d origin_;
  Eigen::Vector3d across_;  // of a cylinder and a ball: length is the radius
  Eigen::Vector3d up_;
  double period_across_, period_up_;
};

/// A scene with its sizes drawn at random. The scanners stand on the x axis, at equal distances from the origin.
[[nodiscard]] std::vector<Surface> scanned_scene(ScannedScene scene, RandomStream& random);

}  // namespace consimd::synth
