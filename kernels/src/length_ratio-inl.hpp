#pragma once

#include "kernel_table.hpp"
#include "length_consistency-inl.hpp"
#include "simd.hpp"

namespace consimd::detail {

/// Length consistent, and the squared lengths alike up to a share of their sum.
template <typename Arch>
struct LengthRatioTest {
  static constexpr bool kFitTogether = false;
  LengthRatioTest(const RawView& view, std::uint32_t seed, RatioBounds bounds)
      : length(view, seed, bounds.bound), ratio(bounds.ratio) {}

  Mask<Arch> operator()(const Vec3<Arch>& source, const Vec3<Arch>& target) const {
    const Vec3<Arch> dp = length.p - source;
    const Vec3<Arch> dq = length.q - target;
    const Batch<Arch> a = dot(dp, dp);
    const Batch<Arch> b = dot(dq, dq);
    return length.agree(a, b) & (larger(b - a, a - b) < ratio * (a + b));
  }

  LengthTest<Arch> length;
  Batch<Arch> ratio;
};

template <typename Arch>
void length_disagreement(const RawView& view, const std::uint32_t* seeds, std::size_t n, RatioBounds bounds,
                         float* costs) {
  const Batch<Arch> bound(bounds.bound);
  const Batch<Arch> ratio(bounds.ratio);
  const Batch<Arch> zero(0.0f);
  const Batch<Arch> one(1.0f);
  for (std::size_t s = 0; s < n; ++s) {
    const Vec3<Arch> p = broadcast<Arch>(view.source, seeds[s]);
    const Vec3<Arch> q = broadcast<Arch>(view.target, seeds[s]);
    InterleavedSum<Arch> sum;
    for (std::size_t j = 0; j < view.padded; j += kWidth<Arch>) {
      const Vec3<Arch> dp = p - load<Arch>(view.source, j);
      const Vec3<Arch> dq = q - load<Arch>(view.target, j);
      const Batch<Arch> a = dot(dp, dp);
      const Batch<Arch> b = dot(dq, dq);
      const Batch<Arch> difference = larger(b - a, a - b);
      const Batch<Arch> lengths = square_root(a) + square_root(b);
      const Batch<Arch> limit = smaller(ratio * (a + b), bound * lengths);
      const Batch<Arch> share = smaller(divide(difference, limit), one);
      sum.add(j, keep<Arch>(limit > zero, share));
    }
    costs[s] = sum.total();
  }
}

template <typename Arch>
void scale_intervals(const RawView& view, std::uint32_t seed, float bound, float* lows, float* highs) {
  const Vec3<Arch> p = broadcast<Arch>(view.source, seed);
  const Vec3<Arch> q = broadcast<Arch>(view.target, seed);
  const Batch<Arch> limit(bound);
  for (std::size_t j = 0; j < view.padded; j += kWidth<Arch>) {
    const Vec3<Arch> dp = p - load<Arch>(view.source, j);
    const Vec3<Arch> dq = q - load<Arch>(view.target, j);
    const Batch<Arch> inverse = divide(Batch<Arch>(1.0f), square_root(dot(dp, dp)));
    const Batch<Arch> length = square_root(dot(dq, dq));
    (larger(length - limit, Batch<Arch>(0.0f)) * inverse).store_unaligned(lows + j);
    ((length + limit) * inverse).store_unaligned(highs + j);
  }
}

}  // namespace consimd::detail
