// The specification of the kernels on pairs of the iterative closest points, as plain loops; see ../scalar.cpp.
#include <cmath>
#include <limits>

#include "../scalar_terms.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail::scalar {
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
