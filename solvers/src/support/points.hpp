// Single points of a correspondence, for what is too little to be a kernel's work. Working frame throughout.
#pragma once

#include <cmath>
#include <cstddef>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

struct Point {
  float x, y, z;
};

inline Point source_point(const CorrespondenceView& view, std::size_t k) {
  return {view.source(0)[k], view.source(1)[k], view.source(2)[k]};
}

inline Point target_point(const CorrespondenceView& view, std::size_t k) {
  return {view.target(0)[k], view.target(1)[k], view.target(2)[k]};
}

inline double distance(const Point& a, const Point& b) {
  const double x = a.x - b.x;
  const double y = a.y - b.y;
  const double z = a.z - b.z;
  return std::sqrt(x * x + y * y + z * z);
}

inline float squared_distance(const Point& a, const Point& b) {
  const float x = a.x - b.x;
  const float y = a.y - b.y;
  const float z = a.z - b.z;
  return x * x + y * y + z * z;
}

inline Point moved(const WorkingPose& pose, const Point& p) {
  const float* r = pose.rotation;
  const float* t = pose.translation;
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
          r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
}

inline Point moved_back(const WorkingPose& pose, const Point& q) {
  const float x = q.x - pose.translation[0];
  const float y = q.y - pose.translation[1];
  const float z = q.z - pose.translation[2];
  const float* r = pose.rotation;
  return {r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z};
}

}  // namespace consimd::detail
