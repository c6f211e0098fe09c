// A scanned room, made up, for tests of the front end.
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include <consimd/kernels/cloud.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::test {

using Points = std::vector<std::array<double, 3>>;

/// Uniform in [-1, 1), the same on every platform.
inline double uniform(std::mt19937& random) { return static_cast<std::int32_t>(random()) * 0x1p-31; }

/// `count` points on the floor, two walls, boxes and a pillar of a room of 10 m, with noise of about a centimetre.
inline Points room(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  Points points;
  std::mt19937 furniture(1);
  std::vector<std::array<double, 6>> boxes;  // corner, size
  for (int b = 0; b < 12; ++b) {
    std::array<double, 6> box{};
    for (double& x : box) x = uniform(furniture);
    boxes.push_back({4.0 * box[0], 4.0 * box[1], 0.0, 0.7 + 0.5 * box[3], 0.7 + 0.5 * box[4], 1.2 + box[5]});
  }
  while (points.size() < count) {
    const double u = uniform(random), v = uniform(random);
    std::array<double, 3> p{};
    switch (random() % 5) {
      case 0:
        p = {5.0 * u, 5.0 * v, 0.0};
        break;
      case 1:
        p = {5.0, 5.0 * u, 1.5 + 1.5 * v};
        break;
      case 2:
        p = {-2.0 + 2.0 * u, 5.0, 1.5 + 1.5 * v};
        break;
      case 3:
        p = {1.0 + 0.3 * std::cos(3.14159 * u), -3.0 + 0.3 * std::sin(3.14159 * u), 1.5 + 1.5 * v};
        break;
      default: {
        const auto& box = boxes[random() % boxes.size()];
        const std::size_t side = random() % 3;
        for (std::size_t c = 0; c < 3; ++c)
          p[c] = box[c] + box[3 + c] * (c == side ? 1.0 : 0.5 + 0.5 * (c == (side + 1) % 3 ? u : v));
        break;
      }
    }
    for (double& x : p) x += 0.01 * uniform(random);
    points.push_back(p);
  }
  return points;
}

inline RigidTransform some_pose() {
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, -0.2, 1.0).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(1.5, -0.8, 0.2);
  return pose;
}

inline Points moved(const RigidTransform& pose, Points points) {
  for (auto& p : points) Eigen::Map<Eigen::Vector3d>(p.data()) = pose * Eigen::Map<Eigen::Vector3d>(p.data());
  return points;
}

inline Cloud cloud_of(const Points& points) {
  return Cloud(PointSpan<double>::interleaved(points.empty() ? nullptr : points.front().data(), points.size()));
}

}  // namespace consimd::test
