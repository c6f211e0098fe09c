// The specification: every kernel as the plain loop that a reader checks against its equation. The vector bodies in
// *-inl.hpp return the same bits. Single precision throughout, without contraction; the order of every sum is part of
// the definition.
#include <cmath>
#include <limits>

#include "kernel_table.hpp"
#include "scalar_terms.hpp"

namespace consimd::detail::scalar {
namespace {

Point source(const RawView& view, std::size_t j) { return {view.source[0][j], view.source[1][j], view.source[2][j]}; }
Point target(const RawView& view, std::size_t j) { return {view.target[0][j], view.target[1][j], view.target[2][j]}; }

/// Writes the bits of predicate(0..size-1), padded to whole words, and returns how many are set.
template <typename Predicate>
std::uint32_t write_bits(const RawView& view, Predicate predicate, std::uint64_t* bits) {
  for (std::size_t word = 0; word < view.padded / 64; ++word) bits[word] = 0;
  std::uint32_t count = 0;
  for (std::size_t j = 0; j < view.size; ++j) {
    if (!predicate(j)) continue;
    bits[j / 64] |= std::uint64_t{1} << (j % 64);
    ++count;
  }
  return count;
}

template <typename Predicate>
std::uint32_t count(const RawView& view, Predicate predicate) {
  std::uint32_t count = 0;
  for (std::size_t j = 0; j < view.size; ++j) count += predicate(j) ? 1u : 0u;
  return count;
}

// ---- Length consistency: | |p_j - p_k| - |q_j - q_k| | < bound, squared twice.

auto length_consistent_with(const RawView& view, std::uint32_t seed, float bound) {
  return [&view, p = source(view, seed), q = target(view, seed), squared = bound * bound](std::size_t j) {
    const Point dp = source(view, j) - p;
    const Point dq = target(view, j) - q;
    const float a = dot(dp, dp);
    const float b = dot(dq, dq);
    const float difference = a - b;
    const float limit = 2.0f * squared * (a + b) - squared * squared;
    const float floor = squared * squared;
    return difference * difference < (limit > floor ? limit : floor);
  };
}

void length_counts(const RawView& view, const std::uint32_t* seeds, std::size_t n, float bound, std::uint32_t* counts) {
  for (std::size_t s = 0; s < n; ++s) counts[s] = count(view, length_consistent_with(view, seeds[s], bound));
}

void length_bits(const RawView& view, const std::uint32_t* seeds, std::size_t n, float bound, std::uint64_t* bits,
                 std::uint32_t* counts) {
  for (std::size_t s = 0; s < n; ++s) {
    counts[s] = write_bits(view, length_consistent_with(view, seeds[s], bound), bits + s * (view.padded / 64));
  }
}

void consistency_matrix(const RawView& view, float bound, std::uint64_t* bits, std::uint32_t* degrees) {
  for (std::uint32_t i = 0; i < view.size; ++i)
    length_bits(view, &i, 1, bound, bits + i * (view.padded / 64), degrees + i);
}

/// The lengths' sum exceeds s when a + b + 2 sqrt(a b) > s^2, squared once more.
void separated_matrix(const RawView& view, SeparatedBounds bounds, std::uint64_t* bits, std::uint32_t* degrees) {
  const float squared_separation = bounds.separation * bounds.separation;
  for (std::uint32_t i = 0; i < view.size; ++i) {
    const auto consistent = length_consistent_with(view, i, bounds.bound);
    const auto separated_and_consistent = [&](std::size_t j) {
      const Point dp = source(view, j) - source(view, i);
      const Point dq = target(view, j) - target(view, i);
      const float a = dot(dp, dp);
      const float b = dot(dq, dq);
      const float rest = squared_separation - (a + b);
      return consistent(j) && (rest < 0.0f || rest * rest < 4.0f * (a * b));
    };
    degrees[i] = write_bits(view, separated_and_consistent, bits + i * (view.padded / 64));
  }
}

// ---- Length ratios.

void ratio_matrix(const RawView& view, RatioBounds bounds, std::uint64_t* bits, std::uint32_t* degrees) {
  for (std::uint32_t i = 0; i < view.size; ++i) {
    const auto consistent = length_consistent_with(view, i, bounds.bound);
    const auto alike_and_consistent = [&](std::size_t j) {
      const Point dp = source(view, j) - source(view, i);
      const Point dq = target(view, j) - target(view, i);
      const float a = dot(dp, dp);
      const float b = dot(dq, dq);
      return consistent(j) && std::fabs(b - a) < bounds.ratio * (a + b);
    };
    degrees[i] = write_bits(view, alike_and_consistent, bits + i * (view.padded / 64));
  }
}

// ---- Angle consistency: the derivation is in angle_consistency.hpp.

auto angle_consistent_with(const RawView& view, IndexPair pair, float bound) {
  // F F and its limit are twelfth powers of lengths. Lifting both by 2^80 keeps them finite for the lengths of a
  // working frame, all below 3.5, and above zero for lengths down to 6e-6; a power of two changes no other bit.
  constexpr float kLift = 0x1p40f;
  const Point p1 = source(view, pair.first);
  const Point p2 = source(view, pair.second);
  const Point q1 = target(view, pair.first);
  const Point q2 = target(view, pair.second);
  const float p12 = dot(p1 - p2, p1 - p2);
  const float q12 = dot(q1 - q2, q1 - q2);
  const float squared = bound * bound;
  const float lifted = squared * kLift * kLift;
  return [=, &view](std::size_t m) {
    const Point p = source(view, m);
    const Point q = target(view, m);
    const float a1 = dot(p1 - p, p1 - p);
    const float a2 = dot(p2 - p, p2 - p);
    const float b1 = dot(q1 - q, q1 - q);
    const float b2 = dot(q2 - q, q2 - q);
    const float S = a1 + a2;
    const float X = a1 * a2;
    const float Y = b1 * b2;
    const float U = S - p12;
    const float V = b1 + b2 - q12;
    const float e1 = a1 - squared;
    const float e2 = a2 - squared;
    const float c = std::sqrt(e1 * e2) - squared;
    const float c2 = c + c;
    const float F = kLift * (V * X - U * c * std::sqrt(Y));
    const bool between = F * F < (4.0f * X - U * U) * (S + c2) * (lifted * Y);
    const bool past_pole = std::fabs(F) * c2 < F * U;
    const bool within_bound = (e1 < e2 ? e1 : e2) <= 0.0f;
    return between || past_pole || within_bound;
  };
}

void angle_counts(const RawView& view, const IndexPair* pairs, std::size_t n, float bound, std::uint32_t* counts) {
  for (std::size_t s = 0; s < n; ++s) counts[s] = count(view, angle_consistent_with(view, pairs[s], bound));
}

void angle_bits(const RawView& view, const IndexPair* pairs, std::size_t n, float bound, std::uint64_t* bits,
                std::uint32_t* counts) {
  for (std::size_t s = 0; s < n; ++s) {
    counts[s] = write_bits(view, angle_consistent_with(view, pairs[s], bound), bits + s * (view.padded / 64));
  }
}

// ---- Alignment residuals: r_j = | R p_j + t - q_j |.

float squared_residual(const WorkingPose& pose, Point p, Point q) {
  const float* r = pose.rotation;
  const float* t = pose.translation;
  const Point moved{r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
                    r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
  return dot(moved - q, moved - q);
}

auto aligned_by(const RawView& view, const WorkingPose& pose, float bound) {
  return [&view, &pose, squared = bound * bound](std::size_t j) {
    return squared_residual(pose, source(view, j), target(view, j)) < squared;
  };
}

void alignment_counts(const RawView& view, const WorkingPose* poses, std::size_t n, float bound,
                      std::uint32_t* counts) {
  for (std::size_t h = 0; h < n; ++h) counts[h] = count(view, aligned_by(view, poses[h], bound));
}

void alignment_bits(const RawView& view, const WorkingPose* poses, std::size_t n, float bound, std::uint64_t* bits,
                    std::uint32_t* counts) {
  for (std::size_t h = 0; h < n; ++h) {
    counts[h] = write_bits(view, aligned_by(view, poses[h], bound), bits + h * (view.padded / 64));
  }
}

void alignment_residuals(const RawView& view, const WorkingPose& pose, float* squared) {
  for (std::size_t j = 0; j < view.padded; ++j) squared[j] = squared_residual(pose, source(view, j), target(view, j));
}
void alignment_scores(const RawView& view, const WorkingPose* poses, std::size_t n, float bound, PoseSupport* support) {
  const float squared = bound * bound;
  for (std::size_t h = 0; h < n; ++h) {
    InterleavedSum residuals;
    std::uint32_t count = 0;
    for (std::size_t j = 0; j < view.size; ++j) {
      const float residual = squared_residual(poses[h], source(view, j), target(view, j));
      if (!(residual < squared)) continue;
      residuals.add(j, residual);
      ++count;
    }
    support[h] = {count, static_cast<float>(count) - residuals.total() / squared};
  }
}

// ---- Length ratios, as sums and as scales.

void length_disagreement(const RawView& view, const std::uint32_t* seeds, std::size_t n, RatioBounds bounds,
                         float* costs) {
  for (std::size_t s = 0; s < n; ++s) {
    InterleavedSum sum;
    for (std::size_t j = 0; j < view.size; ++j) {
      const Point dp = source(view, j) - source(view, seeds[s]);
      const Point dq = target(view, j) - target(view, seeds[s]);
      const float a = dot(dp, dp);
      const float b = dot(dq, dq);
      const float by_ratio = bounds.ratio * (a + b);
      const float by_length = bounds.bound * (std::sqrt(a) + std::sqrt(b));
      const float limit = by_ratio < by_length ? by_ratio : by_length;
      if (!(limit > 0.0f)) continue;
      const float share = std::fabs(b - a) / limit;
      sum.add(j, share < 1.0f ? share : 1.0f);
    }
    costs[s] = sum.total();
  }
}

void scale_intervals(const RawView& view, std::uint32_t seed, float bound, float* lows, float* highs) {
  for (std::size_t j = 0; j < view.padded; ++j) {
    const Point dp = source(view, j) - source(view, seed);
    const Point dq = target(view, j) - target(view, seed);
    const float inverse = 1.0f / std::sqrt(dot(dp, dp));
    const float length = std::sqrt(dot(dq, dq));
    lows[j] = (length - bound > 0.0f ? length - bound : 0.0f) * inverse;
    highs[j] = (length + bound) * inverse;
  }
}

// ---- Rigid moments: interleaved single-precision sums over blocks of 1024 correspondences, joined in double.

constexpr std::size_t kMomentBlock = 1024;

/// weight(j, p, q, w, squared) sets the weight of correspondence j and possibly its squared residual; false leaves j
/// out.
template <typename Weight>
void sum_moments(const RawView& view, Weight weight, RigidMoments* moments) {
  *moments = {};
  for (std::size_t begin = 0; begin < view.size; begin += kMomentBlock) {
    InterleavedSum sums[23];
    for (std::size_t j = begin; j < view.size && j < begin + kMomentBlock; ++j) {
      const Point p = source(view, j);
      const Point q = target(view, j);
      float squared = 0.0f;
      float w = 0.0f;
      if (!weight(j, p, q, w, squared)) continue;
      const Point wp = w * p;
      const Point wq = w * q;
      const float terms[23] = {w,          wp.x,       wp.y,       wp.z,       wq.x,       wq.y,
                               wq.z,       wq.x * p.x, wq.x * p.y, wq.x * p.z, wq.y * p.x, wq.y * p.y,
                               wq.y * p.z, wq.z * p.x, wq.z * p.y, wq.z * p.z, wp.x * p.x, wp.x * p.y,
                               wp.x * p.z, wp.y * p.y, wp.y * p.z, wp.z * p.z, w * squared};
      for (int k = 0; k < 23; ++k) sums[k].add(j, terms[k]);
    }
    const auto total = [&sums](int k) { return static_cast<double>(sums[k].total()); };
    moments->weight += total(0);
    for (int k = 0; k < 3; ++k) moments->source[k] += total(1 + k);
    for (int k = 0; k < 3; ++k) moments->target[k] += total(4 + k);
    for (int k = 0; k < 9; ++k) moments->cross[k] += total(7 + k);
    for (int k = 0; k < 6; ++k) moments->source_scatter[k] += total(16 + k);
    moments->residual += total(22);
  }
}

void weighted_moments(const RawView& view, const float* weights, RigidMoments* moments) {
  sum_moments(
      view,
      [weights](std::size_t j, Point, Point, float& w, float&) {
        w = weights[j];
        return true;
      },
      moments);
  moments->residual = 0.0;  // there is no pose
}

void subset_moments(const RawView& view, const std::uint64_t* bits, RigidMoments* moments) {
  sum_moments(
      view,
      [bits](std::size_t j, Point, Point, float& w, float&) {
        w = 1.0f;
        return (bits[j / 64] >> (j % 64) & 1) != 0;
      },
      moments);
}

float robust_weight(const RawWeight& weight, float squared) {
  switch (weight.function) {
    case WeightFunction::cauchy:
      return 1.0f / (1.0f + squared * weight.inverse_squared_scale);
    case WeightFunction::student_uniform: {
      const float y = 1.0f + squared * weight.inverse_squared_scale;
      float power = y;
      for (std::uint32_t s = 0; s < weight.squarings; ++s) power = power * power;
      return 1.0f / (y * (1.0f + weight.odds * power));
    }
    case WeightFunction::truncated:
      break;
  }
  return 1.0f;
}

void robust_moments(const RawView& view, const WorkingPose& pose, const RawWeight& weight, RigidMoments* moments) {
  sum_moments(
      view,
      [&](std::size_t, Point p, Point q, float& w, float& squared) {
        squared = squared_residual(pose, p, q);
        w = robust_weight(weight, squared);
        return squared < weight.squared_cutoff;
      },
      moments);
}

// ---- Three-point fits.

/// Axes of a triangle's plane and its normal, and the triangle in them: corners (0, 0), (length, 0), (a, b).
struct Triangle {
  Point x, y, z;
  float length, a, b;
  bool degenerate;
};

Triangle triangle(Point p1, Point p2, Point p3) {
  // sine of the angle at p1, squared, below which the plane is taken as undetermined
  constexpr float kSmallestSquaredSine = 1e-10f;
  const Point e1 = p2 - p1;
  const Point e2 = p3 - p1;
  const Point normal = cross(e1, e2);
  const float squared_length = dot(e1, e1);
  const float squared_normal = dot(normal, normal);
  const float length = std::sqrt(squared_length);
  const float normal_length = std::sqrt(squared_normal);
  Triangle t;
  t.x = (1.0f / length) * e1;
  t.z = (1.0f / normal_length) * normal;
  t.y = cross(t.z, t.x);
  t.length = length;
  t.a = dot(e2, t.x);
  t.b = normal_length / length;
  t.degenerate = !(squared_normal > kSmallestSquaredSine * (squared_length * dot(e2, e2)));
  return t;
}

WorkingPose three_point_fit(const RawView& view, const IndexTriple& triple) {
  const Point p1 = source(view, triple.first), p2 = source(view, triple.second), p3 = source(view, triple.third);
  const Point q1 = target(view, triple.first), q2 = target(view, triple.second), q3 = target(view, triple.third);
  const Triangle s = triangle(p1, p2, p3);
  const Triangle t = triangle(q1, q2, q3);

  // Sums over the corners, taken from the centroid, of the products s_i . t_i and s_i x t_i.
  constexpr float kThird = 1.0f / 3.0f;
  const float dots =
      s.length * t.length + s.a * t.a + s.b * t.b - kThird * ((s.length + s.a) * (t.length + t.a) + s.b * t.b);
  const float crosses = s.a * t.b - s.b * t.a - kThird * ((s.length + s.a) * t.b - s.b * (t.length + t.a));
  const float norm = std::sqrt(dots * dots + crosses * crosses);
  const float cosine = dots / norm;
  const float sine = crosses / norm;

  // R = [x_t y_t z_t] Rz [x_s y_s z_s]^T, with [x y] = [x_t y_t] Rz.
  const Point x = cosine * t.x + sine * t.y;
  const Point y = cosine * t.y - sine * t.x;
  const Point row0 = x.x * s.x + y.x * s.y + t.z.x * s.z;
  const Point row1 = x.y * s.x + y.y * s.y + t.z.y * s.z;
  const Point row2 = x.z * s.x + y.z * s.y + t.z.z * s.z;
  const Point p = kThird * (p1 + p2 + p3);
  const Point q = kThird * (q1 + q2 + q3);
  WorkingPose pose{{row0.x, row0.y, row0.z, row1.x, row1.y, row1.z, row2.x, row2.y, row2.z},
                   {q.x - dot(row0, p), q.y - dot(row1, p), q.z - dot(row2, p)}};
  if (s.degenerate || t.degenerate || !(norm > 0.0f)) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (float& entry : pose.rotation) entry = kNan;
    for (float& entry : pose.translation) entry = kNan;
  }
  return pose;
}

void three_point_fits(const RawView& view, const IndexTriple* triples, std::size_t n, WorkingPose* poses) {
  for (std::size_t h = 0; h < n; ++h) poses[h] = three_point_fit(view, triples[h]);
}

// ---- Bit sets.

std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  std::uint32_t count = 0;
  for (std::size_t word = 0; word < words; ++word)
    count += static_cast<std::uint32_t>(__builtin_popcountll(a[word] & b[word]));
  return count;
}

void and_popcount_rows(const std::uint64_t* matrix, std::size_t words, const std::uint64_t* set,
                       const std::uint32_t* rows, std::size_t n, std::uint32_t* counts) {
  for (std::size_t r = 0; r < n; ++r) counts[r] = and_popcount(matrix + rows[r] * words, set, words);
}

void masked_row_sums(const std::uint64_t* rows, std::size_t words, std::size_t n, const float* values, float* sums) {
  for (std::size_t r = 0; r < n; ++r) {
    InterleavedSum sum;
    for (std::size_t j = 0; j < 64 * words; ++j) {
      if ((rows[r * words + j / 64] >> (j % 64) & 1) != 0) sum.add(j, values[j]);
    }
    sums[r] = sum.total();
  }
}

}  // namespace

const KernelTable& table() noexcept {
  static constexpr KernelTable kTable{
      .length_counts = length_counts,
      .length_bits = length_bits,
      .angle_counts = angle_counts,
      .angle_bits = angle_bits,
      .alignment_counts = alignment_counts,
      .alignment_scores = alignment_scores,
      .alignment_bits = alignment_bits,
      .alignment_residuals = alignment_residuals,
      .weighted_moments = weighted_moments,
      .subset_moments = subset_moments,
      .robust_moments = robust_moments,
      .three_point_fits = three_point_fits,
      .consistency_matrix = consistency_matrix,
      .separated_matrix = separated_matrix,
      .ratio_matrix = ratio_matrix,
      .and_popcount = and_popcount,
      .and_popcount_rows = and_popcount_rows,
      .masked_row_sums = masked_row_sums,
      .length_disagreement = length_disagreement,
      .scale_intervals = scale_intervals,
      .clouds = kCloudKernels,
  };
  return kTable;
}

}  // namespace consimd::detail::scalar
