// The plain loops of loop_baseline.hpp with the paper's equations as printed instead of the kernels' algebra.
#include <cmath>

#include "loop_baseline.hpp"

namespace consimd::bench::textbook {
namespace {

float distance(const float* const cloud[3], std::size_t i, std::size_t j) {
  const float x = cloud[0][i] - cloud[0][j];
  const float y = cloud[1][i] - cloud[1][j];
  const float z = cloud[2][i] - cloud[2][j];
  return std::sqrt(x * x + y * y + z * z);
}

/// Angle at point m of the triangle i m j, by the law of cosines.
float angle(const float* const cloud[3], std::size_t i, std::size_t m, std::size_t j) {
  const float a = distance(cloud, i, m);
  const float b = distance(cloud, j, m);
  const float c = distance(cloud, i, j);
  const float cosine = (a * a + b * b - c * c) / (2.0f * a * b);
  return std::acos(std::fmin(std::fmax(cosine, -1.0f), 1.0f));
}

}  // namespace

std::uint32_t length_count(const LoopCloud& c, std::uint32_t seed, float bound) {
  std::uint32_t count = 0;
  for (std::size_t j = 0; j < c.size; ++j) {
    if (std::abs(distance(c.source, seed, j) - distance(c.target, seed, j)) < bound) ++count;
  }
  return count;
}

std::uint32_t angle_count(const LoopCloud& c, std::uint32_t first, std::uint32_t second, float bound) {
  std::uint32_t count = 0;
  for (std::size_t m = 0; m < c.size; ++m) {
    const float a = distance(c.source, first, m);
    const float b = distance(c.source, second, m);
    if (a <= bound || b <= bound) {
      ++count;
    } else {
      const float difference = angle(c.source, first, m, second) - angle(c.target, first, m, second);
      if (std::abs(difference) < std::asin(bound / a) + std::asin(bound / b)) ++count;
    }
  }
  return count;
}

std::uint32_t alignment_count(const LoopCloud& c, const LoopPose& pose, float bound) {
  std::uint32_t count = 0;
  for (std::size_t j = 0; j < c.size; ++j) {
    float squared = 0.0f;
    for (int a = 0; a < 3; ++a) {
      const float* const r = pose.rotation + 3 * a;
      const float moved = r[0] * c.source[0][j] + r[1] * c.source[1][j] + r[2] * c.source[2][j] + pose.translation[a];
      squared += (moved - c.target[a][j]) * (moved - c.target[a][j]);
    }
    if (std::sqrt(squared) < bound) ++count;
  }
  return count;
}

}  // namespace consimd::bench::textbook
