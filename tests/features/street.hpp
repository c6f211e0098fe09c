// A street, made up, and what a spinning scanner sees of it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "scene.hpp"

namespace consimd::test {

/// Boxes with sides along the axes, on the ground z = 0. The street runs along x.
struct Street {
  struct Box {
    std::array<double, 3> low, high;
  };
  std::vector<Box> boxes;

  /// The range to what a ray from `eye` meets first, infinite for nothing.
  [[nodiscard]] double range(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray) const {
    double nearest = ray.z() < 0.0 ? -eye.z() / ray.z() : std::numeric_limits<double>::infinity();
    for (const Box& box : boxes) {
      double enter = 0.0;
      double leave = nearest;
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>(c);
        const double a = (box.low[k] - eye[c]) / ray[c];
        const double b = (box.high[k] - eye[c]) / ray[c];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (enter < leave) nearest = enter;
    }
    return nearest;
  }
};

/// Houses of different depth on both sides, cars and poles; other ones for another seed. Or, bare, two walls alone.
inline Street street(std::uint32_t seed, bool bare = false) {
  std::mt19937 random(seed);
  Street result;
  if (bare) return {{{{-200.0, 6.0, 0.0}, {200.0, 7.0, 8.0}}, {{-200.0, -7.0, 0.0}, {200.0, -6.0, 8.0}}}};
  for (const double side : {-1.0, 1.0}) {
    for (double x = -60.0 + 5.0 * uniform(random); x < 60.0;) {
      const double length = 9.0 + 4.0 * uniform(random);
      const double front = side * (9.0 + 3.0 * uniform(random));
      const double back = front + side * 8.0;
      result.boxes.push_back(
          {{x, std::min(front, back), 0.0}, {x + length, std::max(front, back), 7.0 + uniform(random)}});
      x += length + 2.0 + 2.0 * uniform(random);
    }
    for (double x = -50.0; x < 50.0; x += 9.0 + 5.0 * uniform(random)) {
      const double y = side * (4.5 + uniform(random));
      result.boxes.push_back({{x, y - 0.9, 0.0}, {x + 4.2, y + 0.9, 1.5}});
      const double at = x + 5.0 + uniform(random);
      result.boxes.push_back({{at, y - 0.15, 0.0}, {at + 0.3, y + 0.15, 6.0}});
    }
  }
  return result;
}

/// Like houses on both sides, each with a porch, one every `period` metres: a shift by a house changes nothing.
inline Street like_houses(double period) {
  Street result;
  for (int k = -14; k <= 14; ++k) {
    const double x = k * period;
    for (const double side : {-1.0, 1.0}) {
      const auto box = [&](double from, double to, double front, double back, double height) {
        result.boxes.push_back({{x + from, std::min(side * front, side * back), 0.0},
                                {x + to, std::max(side * front, side * back), height}});
      };
      box(0.0, 0.7 * period, 9.0, 17.0, 6.0);
      box(0.3 * period, 0.3 * period + 1.5, 8.1, 9.0, 2.5);
    }
  }
  return result;
}

/// The scan from (x, 0, 1.7) by a scanner turned by `yaw`, in its frame; noise of 2 cm.
inline Points scan_of(const Street& street, double x, double yaw, std::uint32_t seed, int rings = 40,
                      int columns = 720) {
  constexpr double kFarthest = 70.0;
  std::mt19937 random(seed);
  const Eigen::Vector3d eye(x, 0.0, 1.7);
  Points points;
  for (int ring = 0; ring < rings; ++ring) {
    const double elevation = -0.42 + 0.56 / rings * ring;
    for (int column = 0; column < columns; ++column) {
      const double azimuth = 2.0 * 3.141592653589793 * (column + 0.5 * uniform(random)) / columns;
      const Eigen::Vector3d ray(std::cos(azimuth + yaw) * std::cos(elevation),
                                std::sin(azimuth + yaw) * std::cos(elevation), std::sin(elevation));
      const double range = street.range(eye, ray) + 0.02 * uniform(random);
      if (!(range < kFarthest)) continue;
      const Eigen::Vector3d seen = range * ray;
      points.push_back({std::cos(yaw) * seen.x() + std::sin(yaw) * seen.y(),
                        -std::sin(yaw) * seen.x() + std::cos(yaw) * seen.y(), seen.z()});
    }
  }
  return points;
}

/// T_target_source of scans from x with yaw: source first.
inline RigidTransform between_scans(double source_x, double source_yaw, double target_x, double target_yaw) {
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(source_yaw - target_yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() =
      Eigen::AngleAxisd(-target_yaw, Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(source_x - target_x, 0.0, 0.0);
  return pose;
}

}  // namespace consimd::test
