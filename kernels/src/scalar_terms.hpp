// What the scalar references are written with: points, and sums in the order of the vectors.
#pragma once

#include <cstddef>

namespace consimd::detail::scalar {

struct Point {
  float x, y, z;
};

/// Point i of rows of x, y and z.
inline Point at(const float* const rows[3], std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator*(float s, Point a) { return {s * a.x, s * a.y, s * a.z}; }
inline float dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// Sum of terms 0, 1, 2, ... in 16 interleaved partial sums, joined pairwise: the order that a register of 16 lanes, or
/// several of fewer, can follow.
struct InterleavedSum {
  float lanes[16] = {};

  void add(std::size_t j, float term) { lanes[j % 16] += term; }

  float total() const {
    float sum[16];
    for (int l = 0; l < 16; ++l) sum[l] = lanes[l];
    for (int half = 8; half > 0; half /= 2) {
      for (int l = 0; l < half; ++l) sum[l] += sum[l + half];
    }
    return sum[0];
  }
};

}  // namespace consimd::detail::scalar
