#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

template <typename Arch>
struct Residual {
  explicit Residual(const WorkingPose& pose) {
    for (int k = 0; k < 9; ++k) r[k] = Batch<Arch>(pose.rotation[k]);
    for (int k = 0; k < 3; ++k) t[k] = Batch<Arch>(pose.translation[k]);
  }

  /// | R p + t - q |^2
  Batch<Arch> operator()(const Vec3<Arch>& p, const Vec3<Arch>& q, bool by_multiplier = true) const {
    const Vec3<Arch> moved{r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
                           r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
    const Vec3<Arch> residual{moved.x - q.x, moved.y - q.y, difference(moved.z, q.z, by_multiplier)};
    return dot(residual, residual);
  }

  Batch<Arch> r[9];
  Batch<Arch> t[3];
};

template <typename Arch>
struct AlignmentTest {
  static constexpr bool kFitTogether = false;
  AlignmentTest(const RawView&, const WorkingPose& pose, float bound) : residual(pose), squared(bound * bound) {}

  Mask<Arch> operator()(const Vec3<Arch>& p, const Vec3<Arch>& q, bool by_multiplier) const {
    return residual(p, q, by_multiplier) < squared;
  }

  Residual<Arch> residual;
  Batch<Arch> squared;
};

template <typename Arch>
void alignment_scores(const RawView& view, const WorkingPose* poses, std::size_t n, float bound, PoseSupport* support) {
  for (std::size_t h = 0; h < n; ++h) {
    const Residual<Arch> residual(poses[h]);
    const Batch<Arch> squared(bound * bound);
    InterleavedSum<Arch> sum;
    std::uint32_t count = 0;
    const auto add = [&](std::size_t begin, std::size_t end) {
      std::uint64_t word = 0;
      for (std::size_t k = 0; k < end; k += kWidth<Arch>) {
        const Batch<Arch> r = residual(load<Arch>(view.source, begin + k), load<Arch>(view.target, begin + k));
        const Mask<Arch> supports = r < squared;
        sum.add(k, keep<Arch>(supports, r));
        word |= bitmask(supports) << k;
      }
      count += popcount<Arch>(word);
    };
    // The last word without its padding, which small sets have much of.
    std::size_t begin = 0;
    for (; begin + 64 <= view.size; begin += 64) add(begin, 64);
    if (begin < view.size) add(begin, view.size - begin);
    support[h] = {count, static_cast<float>(count) - sum.total() / (bound * bound)};
  }
}

template <typename Arch>
void alignment_residuals(const RawView& view, const WorkingPose& pose, float* squared) {
  const Residual<Arch> residual(pose);
  for (std::size_t j = 0; j < view.padded; j += kWidth<Arch>) {
    residual(load<Arch>(view.source, j), load<Arch>(view.target, j)).store_unaligned(squared + j);
  }
}

}  // namespace consimd::detail
