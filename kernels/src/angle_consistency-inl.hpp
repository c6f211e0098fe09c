#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

/// Names as in scalar.cpp and angle_consistency.hpp.
template <typename Arch>
struct AngleTest {
  static constexpr bool kFitTogether = false;
  static constexpr float kLift = 0x1p40f;

  AngleTest(const RawView& view, IndexPair pair, float bound)
      : p1(broadcast<Arch>(view.source, pair.first)),
        p2(broadcast<Arch>(view.source, pair.second)),
        q1(broadcast<Arch>(view.target, pair.first)),
        q2(broadcast<Arch>(view.target, pair.second)),
        p12(dot(p1 - p2, p1 - p2)),
        q12(dot(q1 - q2, q1 - q2)),
        squared(bound * bound),
        lifted(bound * bound * kLift * kLift) {}

  /// What is known once both roots are on their way.
  struct Begun {
    Batch<Arch> S, X, Y, U, V, least, root_e, root_y;
  };

  Begun begin(const Vec3<Arch>& p, const Vec3<Arch>& q) const {
    const Vec3<Arch> x1 = p1 - p;
    const Vec3<Arch> x2 = p2 - p;
    const Vec3<Arch> y1 = q1 - q;
    const Vec3<Arch> y2 = q2 - q;
    const Batch<Arch> a1 = dot(x1, x1);
    const Batch<Arch> a2 = dot(x2, x2);
    const Batch<Arch> b1 = dot(y1, y1);
    const Batch<Arch> b2 = dot(y2, y2);
    const Batch<Arch> S = a1 + a2;
    const Batch<Arch> Y = b1 * b2;
    const Batch<Arch> e1 = a1 - squared;
    const Batch<Arch> e2 = a2 - squared;
    return {S, a1 * a2, Y, S - p12, b1 + b2 - q12, smaller(e1, e2), square_root(e1 * e2), square_root(Y)};
  }

  Mask<Arch> finish(const Begun& begun) const {
    const auto& [S, X, Y, U, V, least, root_e, root_y] = begun;
    const Batch<Arch> c = root_e - squared;
    const Batch<Arch> c2 = c + c;
    const Batch<Arch> F = kLift * (V * X - U * c * root_y);
    const Mask<Arch> between = F * F < (4.0f * X - U * U) * (S + c2) * (lifted * Y);
    const Mask<Arch> past_pole = xsimd::abs(F) * c2 < F * U;
    const Mask<Arch> within_bound = least <= Batch<Arch>(0.0f);
    return between | past_pole | within_bound;
  }

  Vec3<Arch> p1, p2, q1, q2;
  Batch<Arch> p12, q12, squared, lifted;
};

}  // namespace consimd::detail
