#include "loop_baseline.hpp"

#include <cmath>

namespace consimd::bench::loop {
namespace {

struct Point {
  float x, y, z;
};

Point point(const float* const cloud[3], std::size_t j) { return {cloud[0][j], cloud[1][j], cloud[2][j]}; }
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Each hypothesis is a functor of the row. It holds copies, which a store to the result cannot alias: the loops
// vectorise.
struct LengthTest {
  LengthTest(const LoopCloud& cloud, std::uint32_t seed, float bound)
      : c(cloud), p(point(c.source, seed)), q(point(c.target, seed)), squared(bound * bound) {}
  bool operator()(std::size_t j) const {
    const Point dp = p - point(c.source, j);
    const Point dq = q - point(c.target, j);
    const float a = dot(dp, dp);
    const float b = dot(dq, dq);
    const float limit = 2.0f * squared * (a + b) - squared * squared;
    const float floor = squared * squared;
    return (a - b) * (a - b) < (limit > floor ? limit : floor);
  }
  LoopCloud c;
  Point p, q;
  float squared;
};

/// The test of angle_consistency.hpp: U V + sqrt((X - U^2) (Y - V^2)) + B sqrt(Y) against sqrt(A Y).
struct AngleTest {
  AngleTest(const LoopCloud& cloud, std::uint32_t first, std::uint32_t second, float bound)
      : c(cloud),
        p1(point(c.source, first)),
        p2(point(c.source, second)),
        q1(point(c.target, first)),
        q2(point(c.target, second)),
        squared(bound * bound) {}
  bool operator()(std::size_t m) const {
    const Point x1 = p1 - point(c.source, m);
    const Point x2 = p2 - point(c.source, m);
    const Point y1 = q1 - point(c.target, m);
    const Point y2 = q2 - point(c.target, m);
    const float a1 = dot(x1, x1);
    const float a2 = dot(x2, x2);
    const float X = a1 * a2;
    const float Y = dot(y1, y1) * dot(y2, y2);
    const float U = dot(x1, x2);
    const float V = dot(y1, y2);
    const float s = X - U * U;
    const float t = Y - V * V;
    const float H = U * V + std::sqrt((s > 0.0f ? s : 0.0f) * (t > 0.0f ? t : 0.0f)) + squared * std::sqrt(Y);
    return ((H > 0.0f) & (H * H > (a1 - squared) * (a2 - squared) * Y)) | (a1 <= squared) | (a2 <= squared);
  }
  LoopCloud c;
  Point p1, p2, q1, q2;
  float squared;
};

struct SquaredResidual {
  float operator()(std::size_t j) const {
    const float* const r = pose.rotation;
    const Point p = point(c.source, j);
    const Point moved{r[0] * p.x + r[1] * p.y + r[2] * p.z + pose.translation[0],
                      r[3] * p.x + r[4] * p.y + r[5] * p.z + pose.translation[1],
                      r[6] * p.x + r[7] * p.y + r[8] * p.z + pose.translation[2]};
    const Point difference = moved - point(c.target, j);
    return dot(difference, difference);
  }
  LoopCloud c;
  LoopPose pose;
};

struct AlignmentTest {
  bool operator()(std::size_t j) const { return residual(j) < squared; }
  SquaredResidual residual;
  float squared;
};

template <typename Test>
std::uint32_t count(std::size_t size, const Test test) {
  std::uint32_t passes = 0;
  for (std::size_t j = 0; j < size; ++j) passes += test(j) ? 1 : 0;
  return passes;
}

template <typename Test>
void mark(std::size_t size, const Test test, std::uint8_t* __restrict passes) {
  for (std::size_t j = 0; j < size; ++j) passes[j] = test(j) ? 1 : 0;
}

void add(const LoopCloud& c, std::size_t j, float weight, LoopMoments* moments) {
  moments->weight += weight;
  for (int a = 0; a < 3; ++a) {
    const float weighted = weight * c.target[a][j];
    moments->source[a] += weight * c.source[a][j];
    moments->target[a] += weighted;
    for (int b = 0; b < 3; ++b) moments->cross[3 * a + b] += weighted * c.source[b][j];
  }
}

}  // namespace

std::uint32_t length_count(const LoopCloud& c, std::uint32_t seed, float bound) {
  return count(c.size, LengthTest(c, seed, bound));
}

std::uint32_t angle_count(const LoopCloud& c, std::uint32_t first, std::uint32_t second, float bound) {
  return count(c.size, AngleTest(c, first, second, bound));
}

std::uint32_t alignment_count(const LoopCloud& c, const LoopPose& pose, float bound) {
  return count(c.size, AlignmentTest{{c, pose}, bound * bound});
}

float alignment_score(const LoopCloud& c, const LoopPose& pose, float bound) {
  const SquaredResidual residual{c, pose};
  const float squared = bound * bound;
  float score = 0.0f;
  for (std::size_t j = 0; j < c.size; ++j) {
    const float term = 1.0f - residual(j) / squared;
    score += term > 0.0f ? term : 0.0f;
  }
  return score;
}

void length_set(const LoopCloud& c, std::uint32_t seed, float bound, std::uint8_t* passes) {
  mark(c.size, LengthTest(c, seed, bound), passes);
}

void angle_set(const LoopCloud& c, std::uint32_t first, std::uint32_t second, float bound, std::uint8_t* passes) {
  mark(c.size, AngleTest(c, first, second, bound), passes);
}

void alignment_set(const LoopCloud& c, const LoopPose& pose, float bound, std::uint8_t* passes) {
  mark(c.size, AlignmentTest{{c, pose}, bound * bound}, passes);
}

LoopMoments weighted_moments(const LoopCloud& c, const float* weights) {
  LoopMoments moments{};
  for (std::size_t j = 0; j < c.size; ++j) add(c, j, weights[j], &moments);
  return moments;
}

LoopMoments cauchy_moments(const LoopCloud& c, const LoopPose& pose, float scale, float cutoff) {
  const SquaredResidual residual{c, pose};
  const float inverse = 1.0f / (scale * scale);
  LoopMoments moments{};
  for (std::size_t j = 0; j < c.size; ++j) {
    const float squared = residual(j);
    add(c, j, squared < cutoff * cutoff ? 1.0f / (1.0f + squared * inverse) : 0.0f, &moments);
  }
  return moments;
}

std::uint32_t common_count(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  std::uint32_t bits = 0;
  for (std::size_t word = 0; word < words; ++word)
    bits += static_cast<std::uint32_t>(__builtin_popcountll(a[word] & b[word]));
  return bits;
}

float masked_sum(const std::uint64_t* bits, std::size_t words, const float* values) {
  float sum = 0.0f;
  for (std::size_t word = 0; word < words; ++word) {
    for (std::uint64_t rest = bits[word]; rest != 0; rest &= rest - 1) {
      sum += values[word * 64 + static_cast<std::size_t>(__builtin_ctzll(rest))];
    }
  }
  return sum;
}

}  // namespace consimd::bench::loop
