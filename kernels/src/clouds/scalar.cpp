// The specification of the kernels on clouds and descriptors, as plain loops; see ../scalar.cpp.
#include <cmath>
#include <limits>

#include "../scalar_terms.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail::scalar {
namespace {

Point at(const float* const rows[3], std::size_t i) { return {rows[0][i], rows[1][i], rows[2][i]}; }

}  // namespace

std::size_t neighbours_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                              float radius, std::uint32_t* indices, float* squared) {
  const Point q{query[0], query[1], query[2]};
  std::size_t count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; ++i) {
      const Point offset = at(cloud.points, i) - q;
      const float distance = dot(offset, offset);
      if (!(distance <= radius * radius)) continue;
      indices[count] = i;
      squared[count] = distance;
      ++count;
    }
  }
  return count;
}

std::size_t nearest_within(const RawPoints& cloud, const float query[3], const PointRun* runs, std::size_t n,
                           float radius, std::size_t most, std::uint32_t* indices, float* squared) {
  const Point q{query[0], query[1], query[2]};
  std::size_t count = 0;
  for (std::size_t r = 0; r < n; ++r) {
    for (std::uint32_t i = runs[r].first; i < runs[r].last; ++i) {
      const Point offset = at(cloud.points, i) - q;
      const float distance = dot(offset, offset);
      if (!(distance <= radius * radius)) continue;
      const auto nearer = [&](std::size_t rank) {
        return distance < squared[rank] || (distance == squared[rank] && i < indices[rank]);
      };
      if (count == most && !nearer(most - 1)) continue;
      std::size_t rank = count < most ? count++ : most - 1;
      for (; rank > 0 && nearer(rank - 1); --rank) {
        squared[rank] = squared[rank - 1];
        indices[rank] = indices[rank - 1];
      }
      squared[rank] = distance;
      indices[rank] = i;
    }
  }
  return count;
}

void neighbourhood_scatter(const RawPoints& cloud, const float centre[3], const std::uint32_t* indices, std::size_t n,
                           float unit, float scatter[6]) {
  const Point c{centre[0], centre[1], centre[2]};
  const float shrink = 1.0f / unit;
  InterleavedSum x, y, z, xx, xy, xz, yy, yz, zz;
  for (std::size_t j = 0; j < n; ++j) {
    const Point d = shrink * (at(cloud.points, indices[j]) - c);
    x.add(j, d.x);
    y.add(j, d.y);
    z.add(j, d.z);
    xx.add(j, d.x * d.x);
    xy.add(j, d.x * d.y);
    xz.add(j, d.x * d.z);
    yy.add(j, d.y * d.y);
    yz.add(j, d.y * d.z);
    zz.add(j, d.z * d.z);
  }
  const float share = 1.0f / static_cast<float>(n);
  const Point sum{x.total(), y.total(), z.total()};
  const Point mean = share * sum;
  scatter[0] = xx.total() - sum.x * mean.x;
  scatter[1] = xy.total() - sum.x * mean.y;
  scatter[2] = xz.total() - sum.x * mean.z;
  scatter[3] = yy.total() - sum.y * mean.y;
  scatter[4] = yz.total() - sum.y * mean.z;
  scatter[5] = zz.total() - sum.z * mean.z;
}

// ---- Principal axes: Jacobi's rotations, each of which makes one entry beside the diagonal zero.

namespace {

/// A symmetric matrix while it is made diagonal, and the columns of the rotation that does it.
struct Diagonalisation {
  float diagonal[3];
  float beside[3];  ///< beside[k]: the entry in the rows other than k
  float columns[3][3];

  /// Makes entry (p, q) zero; r is the third row.
  void rotate(int p, int q, int r) {
    const float e = beside[r] + beside[r];
    const float d = diagonal[q] - diagonal[p];
    const float h = std::fabs(d) + std::sqrt(d * d + e * e);
    const float t = h > 0.0f ? (d < 0.0f ? 0.0f - e : e) / h : 0.0f;
    const float c = 1.0f / std::sqrt(t * t + 1.0f);
    const float s = t * c;
    diagonal[p] = diagonal[p] - t * beside[r];
    diagonal[q] = diagonal[q] + t * beside[r];
    beside[r] = 0.0f;
    const float rp = beside[q];
    const float rq = beside[p];
    beside[q] = c * rp - s * rq;
    beside[p] = s * rp + c * rq;
    for (int k = 0; k < 3; ++k) {
      const float of_p = columns[p][k];
      const float of_q = columns[q][k];
      columns[p][k] = c * of_p - s * of_q;
      columns[q][k] = s * of_p + c * of_q;
    }
  }
};

}  // namespace

void principal_axes(const float* const scatter[6], std::size_t n, float* const axes[3], float* const values[3]) {
  constexpr int kSweeps = 4;
  for (std::size_t i = 0; i < n; ++i) {
    Diagonalisation m{{scatter[0][i], scatter[3][i], scatter[5][i]},
                      {scatter[4][i], scatter[2][i], scatter[1][i]},
                      {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}}};
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      m.rotate(0, 1, 2);
      m.rotate(0, 2, 1);
      m.rotate(1, 2, 0);
    }
    const float* d = m.diagonal;
    const bool second_below_first = d[1] < d[0];
    const float low = second_below_first ? d[1] : d[0];
    const float high = second_below_first ? d[0] : d[1];
    const bool third_lowest = d[2] < low;
    for (int k = 0; k < 3; ++k) {
      axes[k][i] = third_lowest ? m.columns[2][k] : second_below_first ? m.columns[1][k] : m.columns[0][k];
    }
    const bool third_highest = high < d[2];
    values[0][i] = third_lowest ? d[2] : low;
    values[1][i] = third_lowest ? low : third_highest ? high : d[2];
    values[2][i] = third_highest ? d[2] : high;
  }
}

// ---- Pair features.

void pair_feature_counts(const RawPoints& cloud, std::uint32_t point, const std::uint32_t* indices, std::size_t n,
                         std::uint32_t* counts) {
  for (std::size_t bin = 0; bin < 3 * kFeatureBins; ++bin) counts[bin] = 0;
  const Point p1 = at(cloud.points, point);
  const Point n1 = at(cloud.normals, point);
  for (std::size_t j = 0; j < n; ++j) {
    const Point d = at(cloud.points, indices[j]) - p1;
    const Point n2 = at(cloud.normals, indices[j]);
    const float squared_length = dot(d, d);
    const float along1 = dot(n1, d);
    const float along2 = dot(n2, d);
    const float cosine = dot(n1, n2);
    const float volume = dot(cross(n1, n2), d);
    // The end whose normal is nearer to the line is the source, whose frame the features are measured in.
    const bool swapped = std::fabs(along1) < std::fabs(along2);
    const float along_source = swapped ? 0.0f - along2 : along1;
    const float along_target = swapped ? 0.0f - along1 : along2;
    const float squared_v = squared_length - along_source * along_source;
    const bool has_normals = cosine == cosine;  // NOLINT(misc-redundant-expression): not NaN
    if (!(squared_length > 0.0f) || !(squared_v > 0.0f) || !has_normals) continue;
    const float turned = along_target - along_source * cosine;
    const float reach = cosine * std::sqrt(squared_v);

    const float of_turned = std::fabs(turned);
    const float squared_volume = volume * volume;
    const float squared_along = along_source * along_source;
    std::size_t steps[3] = {};
    for (std::size_t& b = steps[0]; b < 5 && kSines[b] * reach <= kCosines[b] * of_turned;) ++b;
    for (std::size_t& b = steps[1]; b < 5 && kSquaredShares[b] * squared_v <= squared_volume;) ++b;
    for (std::size_t& b = steps[2]; b < 5 && kSquaredShares[b] * squared_length <= squared_along;) ++b;
    const float signs[3] = {turned, volume, along_source};
    for (std::size_t f = 0; f < 3; ++f) {
      ++counts[f * kFeatureBins + (signs[f] < 0.0f ? 5 - steps[f] : 5 + steps[f])];
    }
  }
}

void weighted_histogram_sum(const float* histograms, const std::uint32_t* rows, const float* squared, std::size_t n,
                            float* sum) {
  for (int bin = 0; bin < 48; ++bin) sum[bin] = 0.0f;
  for (std::size_t j = 0; j < n; ++j) {
    if (!(squared[j] > 0.0f)) continue;
    const float weight = 1.0f / squared[j];
    for (std::size_t bin = 0; bin < 48; ++bin) sum[bin] = sum[bin] + weight * histograms[48 * rows[j] + bin];
  }
}

// ---- Matches.

namespace {

/// Enters a distance below the last rank's; equal ones stay in the order in which they come.
void enter(const RawMatches& best, std::size_t k, std::size_t i, std::int32_t distance, std::uint32_t index) {
  std::size_t rank = k - 1;
  if (!(distance < best.distances[rank * best.stride + i])) return;
  for (; rank > 0 && distance < best.distances[(rank - 1) * best.stride + i]; --rank) {
    best.distances[rank * best.stride + i] = best.distances[(rank - 1) * best.stride + i];
    best.indices[rank * best.stride + i] = best.indices[(rank - 1) * best.stride + i];
  }
  best.distances[rank * best.stride + i] = distance;
  best.indices[rank * best.stride + i] = index;
}

}  // namespace

void best_matches(const RawDescriptors& queries, std::size_t first, std::size_t last, const RawDescriptors& targets,
                  std::size_t k, const RawMatches& of_queries, const RawMatches& of_targets) {
  const std::size_t length = 2 * queries.pairs;
  for (std::size_t i = first; i < last; ++i) {
    for (std::size_t j = 0; j < targets.size; ++j) {
      std::int32_t product = 0;
      for (std::size_t c = 0; c < length; ++c) {
        product += std::int32_t{queries.rows[i * length + c]} * std::int32_t{targets.rows[j * length + c]};
      }
      const std::int32_t distance = queries.squared_norms[i] + targets.squared_norms[j] - 2 * product;
      enter(of_queries, k, i, distance, static_cast<std::uint32_t>(j));
      enter(of_targets, k, j, distance, static_cast<std::uint32_t>(i));
    }
  }
}

// ---- Pairs of the iterative closest points.

namespace {

Point turned(const float rotation[9], Point p) {
  return {dot(Point{rotation[0], rotation[1], rotation[2]}, p), dot(Point{rotation[3], rotation[4], rotation[5]}, p),
          dot(Point{rotation[6], rotation[7], rotation[8]}, p)};
}

Point entry(const float points[3][PairBlock::kSize], std::size_t i) {
  return {points[0][i], points[1][i], points[2][i]};
}

/// A pair's e and M = isotropic I + u_share u u^T + v_share v v^T.
struct PairTerm {
  Point e;
  float isotropic = 0.0f;
  float u_share = 0.0f;
  float v_share = 0.0f;
  Point u{};
  Point v{};
  float squared = 0.0f;  ///< e^T M e

  /// False where entry i is no pair.
  bool read(const RawPoints& target, const PairBlock& block, std::size_t i, const PairProblem& problem) {
    e = entry(block.points, i) - at(target.points, block.rows[i]);
    const float length = dot(e, e);
    if (!(length <= problem.max_distance * problem.max_distance)) return false;
    if (problem.metric == PairMetric::point) {
      isotropic = 1.0f;
      squared = length;
      return true;
    }
    const Point n = at(target.normals, block.rows[i]);
    if (problem.metric == PairMetric::plane) {
      u_share = 1.0f;
      u = n;
      const float along = dot(u, e);
      squared = along * along;
      return squared >= 0.0f;  // not with NaN
    }
    // n n^T + m m^T = (u u^T + v v^T) / 2 with u = n + m and v = n - m, which are normal to one another.
    constexpr float kShared = 1.0f - kAlongNormal;
    constexpr float kShare = 0.5f * kAlongNormal * kShared;
    const Point m = turned(problem.rotation, entry(block.normals, i));
    const float cosine = dot(n, m);
    isotropic = kAlongNormal;
    u = n + m;
    v = n - m;
    u_share = kShare / (2.0f - kShared * (1.0f + cosine));
    v_share = kShare / (2.0f - kShared * (1.0f - cosine));
    const float along_u = dot(u, e);
    const float along_v = dot(v, e);
    squared = kAlongNormal * length + u_share * (along_u * along_u) + v_share * (along_v * along_v);
    return squared >= 0.0f;
  }
};

/// The lower triangle of J^T J and J^T e, J = (-[a]x, I).
struct IsotropicPart {
  float normal[21];
  float score[6];

  IsotropicPart(Point a, Point e)
      : normal{a.y * a.y + a.z * a.z,
               0.0f - a.y * a.x,
               a.x * a.x + a.z * a.z,
               0.0f - a.z * a.x,
               0.0f - a.z * a.y,
               a.x * a.x + a.y * a.y,
               0.0f,
               a.z,
               0.0f - a.y,
               1.0f,
               0.0f - a.z,
               0.0f,
               a.x,
               0.0f,
               1.0f,
               a.y,
               0.0f - a.x,
               0.0f,
               0.0f,
               0.0f,
               1.0f} {
    const Point turn = cross(a, e);
    const float all[6] = {turn.x, turn.y, turn.z, e.x, e.y, e.z};
    for (int r = 0; r < 6; ++r) score[r] = all[r];
  }
};

}  // namespace

void move_pairs(PairBlock& block, std::size_t n, const WorkingMotion& motion, std::uint64_t* stale) {
  for (std::size_t word = 0; word < PairBlock::kSize / 64; ++word) stale[word] = 0;
  const Point shift{motion.shift[0], motion.shift[1], motion.shift[2]};
  const Point shift_rest{motion.shift_rest[0], motion.shift_rest[1], motion.shift_rest[2]};
  for (std::size_t i = 0; i < n; ++i) {
    const Point p = entry(block.from, i);
    const Point x = (turned(motion.linear, p) + shift) + (turned(motion.linear_rest, p) + shift_rest);
    block.points[0][i] = x.x;
    block.points[1][i] = x.y;
    block.points[2][i] = x.z;
    const Point way = x - entry(block.looked, i);
    if (!(std::sqrt(dot(way, way)) + kDistanceRounding < block.trust[i])) stale[i / 64] |= std::uint64_t{1} << i % 64;
  }
}

void pair_residuals(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    float* squared) {
  for (std::size_t i = 0; i < n; ++i) {
    PairTerm term;
    squared[i] = term.read(target, block, i, problem) ? term.squared : std::numeric_limits<float>::quiet_NaN();
  }
}

void pair_equations(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    PairEquations& equations) {
  InterleavedSum normal[21], score[6], weight, spread, squared_score, slope, squared_length;
  const Point centre{problem.centre[0], problem.centre[1], problem.centre[2]};
  const float per_square = 1.0f / (kCauchy * kCauchy * (problem.scale * problem.scale));
  equations.pairs = 0;
  for (std::size_t i = 0; i < n; ++i) {
    PairTerm term;
    if (!term.read(target, block, i, problem)) continue;
    ++equations.pairs;
    const Point a = entry(block.points, i) - centre;
    const float w = 1.0f / (1.0f + term.squared * per_square);
    const auto row_of = [&](Point along, float(&row)[6]) {
      const Point lever = cross(a, along);
      const float all[6] = {lever.x, lever.y, lever.z, along.x, along.y, along.z};
      for (int r = 0; r < 6; ++r) row[r] = all[r];
    };
    float u[6], v[6];
    row_of(term.u, u);
    row_of(term.v, v);
    const IsotropicPart part(a, term.e);
    const float wi = w * term.isotropic;
    const float wu = w * term.u_share;
    const float wv = w * term.v_share;
    const float force_u = wu * dot(term.u, term.e);
    const float force_v = wv * dot(term.v, term.e);
    const auto sum = [&](float of_u, float of_v, float isotropic) {
      switch (problem.metric) {
        case PairMetric::point:
          return isotropic;
        case PairMetric::plane:
          return of_u;
        case PairMetric::gicp:
          break;
      }
      return of_u + of_v + isotropic;
    };
    for (int r = 0, k = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c, ++k) {
        normal[k].add(i, sum(wu * u[r] * u[c], wv * v[r] * v[c], wi * part.normal[k]));
      }
      score[r].add(i, sum(force_u * u[r], force_v * v[r], wi * part.score[r]));
    }
    weight.add(i, w);
    spread.add(i, w * dot(a, a));
    squared_score.add(i, w * w * term.squared);
    slope.add(i, w * (w + w - 1.0f));
    squared_length.add(i, problem.metric == PairMetric::plane ? term.squared : dot(term.e, term.e));
  }
  for (int k = 0; k < 21; ++k) equations.normal[k] = normal[k].total();
  for (int r = 0; r < 6; ++r) equations.score[r] = score[r].total();
  equations.weight = weight.total();
  equations.spread = spread.total();
  equations.squared_score = squared_score.total();
  equations.slope = slope.total();
  equations.squared_length = squared_length.total();
}

}  // namespace consimd::detail::scalar
