#pragma once

#include "neighbourhoods-inl.hpp"

namespace consimd::detail {

template <typename Arch>
inline Vec3<Arch> entries(const float (&points)[3][PairBlock::kSize], std::size_t i) {
  return {Batch<Arch>::load_aligned(points[0] + i), Batch<Arch>::load_aligned(points[1] + i),
          Batch<Arch>::load_aligned(points[2] + i)};
}

template <typename Arch>
inline Vec3<Arch> spread(const float (&point)[3]) {
  return {Batch<Arch>(point[0]), Batch<Arch>(point[1]), Batch<Arch>(point[2])};
}

/// A 3 x 3 matrix in every lane.
template <typename Arch>
struct Turn {
  Vec3<Arch> rows[3];

  explicit Turn(const float (&m)[9])
      : rows{{Batch<Arch>(m[0]), Batch<Arch>(m[1]), Batch<Arch>(m[2])},
             {Batch<Arch>(m[3]), Batch<Arch>(m[4]), Batch<Arch>(m[5])},
             {Batch<Arch>(m[6]), Batch<Arch>(m[7]), Batch<Arch>(m[8])}} {}

  Vec3<Arch> operator()(const Vec3<Arch>& p) const { return {dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)}; }
};

template <typename Arch>
void move_pairs(PairBlock& block, std::size_t n, const WorkingMotion& motion, std::uint64_t* stale) {
  for (std::size_t word = 0; word < PairBlock::kSize / 64; ++word) stale[word] = 0;
  const Turn<Arch> turn(motion.linear), turn_rest(motion.linear_rest);
  const Vec3<Arch> shift = spread<Arch>(motion.shift), shift_rest = spread<Arch>(motion.shift_rest);
  const Batch<Arch> rounding(kDistanceRounding);
  for (std::size_t i = 0; i < n; i += kWidth<Arch>) {
    const Vec3<Arch> p = entries<Arch>(block.from, i);
    const Vec3<Arch> x = (turn(p) + shift) + (turn_rest(p) + shift_rest);
    x.x.store_aligned(block.points[0] + i);
    x.y.store_aligned(block.points[1] + i);
    x.z.store_aligned(block.points[2] + i);
    const Vec3<Arch> way = x - entries<Arch>(block.looked, i);
    const Mask<Arch> trusted = square_root(dot(way, way)) + rounding < Batch<Arch>::load_aligned(block.trust + i);
    stale[i / 64] |= (~bitmask(trusted) & lowest_bits<Arch>(n - i)) << i % 64;
  }
}

/// As in scalar.cpp, 0 where there is no pair; u and v as far as the metric has them.
template <typename Arch, PairMetric kMetric>
struct PairTerm {
  Mask<Arch> present;
  Vec3<Arch> e, u, v;
  Batch<Arch> u_share, v_share, squared;
};

template <typename Arch, PairMetric kMetric>
class PairTerms {
 public:
  PairTerms(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem)
      : target_(target),
        block_(block),
        n_(n),
        rotation_(problem.rotation),
        limit_(problem.max_distance * problem.max_distance) {}

  /// Gives the terms of entries i to i + width - 1.
  PairTerm<Arch, kMetric> operator()(std::size_t i) const {
    const Batch<Arch> zero(0.0f);
    const IndexBlock<Arch> rows(block_.rows, n_, i);
    PairTerm<Arch, kMetric> term;
    term.e = entries<Arch>(block_.points, i) - rows.points(target_.points);
    const Batch<Arch> length = dot(term.e, term.e);
    term.present = (length <= limit_) & mask_of(lowest_bits<Arch>(n_ - i), Arch{});
    if constexpr (kMetric == PairMetric::point) {
      term.squared = length;
    } else {
      const Vec3<Arch> n = rows.points(target_.normals);
      if constexpr (kMetric == PairMetric::plane) {
        term.u = n;
        const Batch<Arch> along = dot(term.u, term.e);
        term.squared = along * along;
      } else {
        constexpr float kShared = 1.0f - kAlongNormal;
        const Batch<Arch> one(1.0f), two(2.0f), shared(kShared), share(0.5f * kAlongNormal * kShared);
        const Vec3<Arch> m = rotation_(entries<Arch>(block_.normals, i));
        const Batch<Arch> cosine = dot(n, m);
        term.u = n + m;
        term.v = n - m;
        term.u_share = divide(share, two - shared * (one + cosine));
        term.v_share = divide(share, two - shared * (one - cosine));
        const Batch<Arch> along_u = dot(term.u, term.e);
        const Batch<Arch> along_v = dot(term.v, term.e);
        term.squared = Batch<Arch>(kAlongNormal) * length + term.u_share * (along_u * along_u) +
                       term.v_share * (along_v * along_v);
      }
      term.present = term.present & (term.squared >= zero);
      term.u = kept(term.present, term.u);
    }
    if constexpr (kMetric == PairMetric::gicp) {
      term.v = kept(term.present, term.v);
      term.u_share = keep<Arch>(term.present, term.u_share);
      term.v_share = keep<Arch>(term.present, term.v_share);
    }
    term.e = kept(term.present, term.e);
    term.squared = keep<Arch>(term.present, term.squared);
    return term;
  }

  static Vec3<Arch> kept(const Mask<Arch>& present, const Vec3<Arch>& p) {
    return {keep<Arch>(present, p.x), keep<Arch>(present, p.y), keep<Arch>(present, p.z)};
  }

 private:
  const RawPoints& target_;
  const PairBlock& block_;
  std::size_t n_;
  Turn<Arch> rotation_;
  Batch<Arch> limit_;
};

/// As in scalar.cpp.
template <typename Arch>
struct IsotropicPart {
  Batch<Arch> normal[21];
  Batch<Arch> score[6];

  IsotropicPart(const Vec3<Arch>& a, const Vec3<Arch>& e) {
    const Batch<Arch> zero(0.0f), one(1.0f);
    const Batch<Arch> xx = a.x * a.x, yy = a.y * a.y, zz = a.z * a.z;
    const Batch<Arch> all[21] = {yy + zz,
                                 zero - a.y * a.x,
                                 xx + zz,
                                 zero - a.z * a.x,
                                 zero - a.z * a.y,
                                 xx + yy,
                                 zero,
                                 a.z,
                                 zero - a.y,
                                 one,
                                 zero - a.z,
                                 zero,
                                 a.x,
                                 zero,
                                 one,
                                 a.y,
                                 zero - a.x,
                                 zero,
                                 zero,
                                 zero,
                                 one};
    for (int k = 0; k < 21; ++k) normal[k] = all[k];
    const Vec3<Arch> turn = cross(a, e);
    const Batch<Arch> scores[6] = {turn.x, turn.y, turn.z, e.x, e.y, e.z};
    for (int r = 0; r < 6; ++r) score[r] = scores[r];
  }
};

/// (a cross along, along).
template <typename Arch>
struct Row {
  Batch<Arch> entries[6];

  Row(const Vec3<Arch>& a, const Vec3<Arch>& along) {
    const Vec3<Arch> lever = cross(a, along);
    const Batch<Arch> all[6] = {lever.x, lever.y, lever.z, along.x, along.y, along.z};
    for (int r = 0; r < 6; ++r) entries[r] = all[r];
  }
};

template <typename Arch, PairMetric kMetric>
void sum_equations(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                   PairEquations& equations) {
  InterleavedSum<Arch> normal[21], score[6], weight, arm, squared_score, slope, squared_length;
  const Vec3<Arch> centre = spread<Arch>(problem.centre);
  const Batch<Arch> one(1.0f);
  const Batch<Arch> per_square(1.0f / (kCauchy * kCauchy * (problem.scale * problem.scale)));
  const PairTerms<Arch, kMetric> terms(target, block, n, problem);
  equations.pairs = 0;
  for (std::size_t i = 0; i < n; i += kWidth<Arch>) {
    const auto term = terms(i);
    equations.pairs += popcount<Arch>(bitmask(term.present));
    const Vec3<Arch> a = terms.kept(term.present, entries<Arch>(block.points, i) - centre);
    const Batch<Arch> w = keep<Arch>(term.present, divide(one, one + term.squared * per_square));
    if constexpr (kMetric == PairMetric::point) {
      const IsotropicPart<Arch> part(a, term.e);
      for (int k = 0; k < 21; ++k) normal[k].add(i, w * part.normal[k]);
      for (int r = 0; r < 6; ++r) score[r].add(i, w * part.score[r]);
    } else if constexpr (kMetric == PairMetric::plane) {
      const Row<Arch> u(a, term.u);
      const Batch<Arch> force = w * dot(term.u, term.e);
      for (int r = 0, k = 0; r < 6; ++r) {
        const Batch<Arch> weighted = w * u.entries[r];
        for (int c = 0; c <= r; ++c, ++k) normal[k].add(i, weighted * u.entries[c]);
        score[r].add(i, force * u.entries[r]);
      }
    } else {
      const Row<Arch> u(a, term.u), v(a, term.v);
      const IsotropicPart<Arch> part(a, term.e);
      const Batch<Arch> wi = w * Batch<Arch>(kAlongNormal), wu = w * term.u_share, wv = w * term.v_share;
      const Batch<Arch> force_u = wu * dot(term.u, term.e), force_v = wv * dot(term.v, term.e);
      for (int r = 0, k = 0; r < 6; ++r) {
        const Batch<Arch> weighted_u = wu * u.entries[r], weighted_v = wv * v.entries[r];
        for (int c = 0; c <= r; ++c, ++k) {
          normal[k].add(i, weighted_u * u.entries[c] + weighted_v * v.entries[c] + wi * part.normal[k]);
        }
        score[r].add(i, force_u * u.entries[r] + force_v * v.entries[r] + wi * part.score[r]);
      }
    }
    weight.add(i, w);
    arm.add(i, w * dot(a, a));
    squared_score.add(i, w * w * term.squared);
    slope.add(i, w * (w + w - one));
    squared_length.add(i, kMetric == PairMetric::plane ? term.squared : dot(term.e, term.e));
  }
  for (int k = 0; k < 21; ++k) equations.normal[k] = normal[k].total();
  for (int r = 0; r < 6; ++r) equations.score[r] = score[r].total();
  equations.weight = weight.total();
  equations.spread = arm.total();
  equations.squared_score = squared_score.total();
  equations.slope = slope.total();
  equations.squared_length = squared_length.total();
}

template <typename Arch>
void pair_equations(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    PairEquations& equations) {
  switch (problem.metric) {
    case PairMetric::point:
      return sum_equations<Arch, PairMetric::point>(target, block, n, problem, equations);
    case PairMetric::plane:
      return sum_equations<Arch, PairMetric::plane>(target, block, n, problem, equations);
    case PairMetric::gicp:
      return sum_equations<Arch, PairMetric::gicp>(target, block, n, problem, equations);
  }
}

template <typename Arch, PairMetric kMetric>
void residuals(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
               float* squared) {
  const PairTerms<Arch, kMetric> terms(target, block, n, problem);
  const Batch<Arch> none(__builtin_nanf(""));
  alignas(64) float lanes[kWidth<Arch>];
  for (std::size_t i = 0; i < n; i += kWidth<Arch>) {
    const auto term = terms(i);
    xsimd::select(term.present, term.squared, none).store_aligned(lanes);
    for (std::size_t l = 0; l < kWidth<Arch> && i + l < n; ++l) squared[i + l] = lanes[l];
  }
}

template <typename Arch>
void pair_residuals(const RawPoints& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    float* squared) {
  switch (problem.metric) {
    case PairMetric::point:
      return residuals<Arch, PairMetric::point>(target, block, n, problem, squared);
    case PairMetric::plane:
      return residuals<Arch, PairMetric::plane>(target, block, n, problem, squared);
    case PairMetric::gicp:
      return residuals<Arch, PairMetric::gicp>(target, block, n, problem, squared);
  }
}

}  // namespace consimd::detail
