#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

template <typename Arch>
struct LengthTest {
  static constexpr bool kFitTogether = true;
  LengthTest(const RawView& view, std::uint32_t seed, float bound)
      : p(broadcast<Arch>(view.source, seed)),
        q(broadcast<Arch>(view.target, seed)),
        twice_squared(2.0f * (bound * bound)),
        floor((bound * bound) * (bound * bound)) {}

  Mask<Arch> operator()(const Vec3<Arch>& source, const Vec3<Arch>& target, bool by_multiplier) const {
    const Vec3<Arch> dp = p - source;
    const Vec3<Arch> dq{q.x - target.x, q.y - target.y, difference(q.z, target.z, by_multiplier)};
    return agree(dot(dp, dp), dot(dq, dq));
  }

  /// a, b: squared lengths.
  Mask<Arch> agree(const Batch<Arch>& a, const Batch<Arch>& b) const {
    const Batch<Arch> excess = difference(a, b);
    return below_larger(excess * excess, twice_squared * (a + b) - floor, floor);
  }

  Vec3<Arch> p, q;
  Batch<Arch> twice_squared, floor;
};

/// Length consistent, and the two lengths add up to more than a separation.
template <typename Arch>
struct SeparatedLengthTest {
  static constexpr bool kFitTogether = false;
  SeparatedLengthTest(const RawView& view, std::uint32_t seed, SeparatedBounds bounds)
      : length(view, seed, bounds.bound), squared_separation(bounds.separation * bounds.separation) {}

  Mask<Arch> operator()(const Vec3<Arch>& source, const Vec3<Arch>& target) const {
    const Vec3<Arch> dp = length.p - source;
    const Vec3<Arch> dq = length.q - target;
    const Batch<Arch> a = dot(dp, dp);
    const Batch<Arch> b = dot(dq, dq);
    const Batch<Arch> rest = squared_separation - (a + b);
    return length.agree(a, b) & ((rest < Batch<Arch>(0.0f)) | (rest * rest < 4.0f * (a * b)));
  }

  LengthTest<Arch> length;
  Batch<Arch> squared_separation;
};

}  // namespace consimd::detail
