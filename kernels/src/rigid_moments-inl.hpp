#pragma once

#include "alignment_residuals-inl.hpp"
#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

/// Weights of `width` correspondences: lanes outside `chosen` take no part, whatever their numbers.
template <typename Arch>
struct Weights {
  Mask<Arch> chosen;
  Batch<Arch> weight;
  Batch<Arch> squared_residual;
};

/// weigh(j, p, q) gives the Weights of correspondences j .. j + width - 1.
template <typename Arch, bool kWithResidual, typename Weigh>
inline void sum_moments(const RawView& view, const Weigh& weigh, RigidMoments* moments) {
  constexpr std::size_t kMomentBlock = 1024;
  *moments = {};
  for (std::size_t begin = 0; begin < view.padded; begin += kMomentBlock) {
    const std::size_t end = begin + kMomentBlock < view.padded ? begin + kMomentBlock : view.padded;
    InterleavedSum<Arch> weight, source[3], target[3], cross[9], scatter[6], residual;
    for (std::size_t word = begin; word < end; word += 64) {
      for (std::size_t k = 0; k < 64; k += kWidth<Arch>) {
        const Vec3<Arch> p_all = load<Arch>(view.source, word + k);
        const Vec3<Arch> q_all = load<Arch>(view.target, word + k);
        const Weights<Arch> weights = weigh(word + k, p_all, q_all);
        const Mask<Arch>& chosen = weights.chosen;
        const Batch<Arch> w = keep<Arch>(chosen, weights.weight);
        const Batch<Arch> p[3] = {keep<Arch>(chosen, p_all.x), keep<Arch>(chosen, p_all.y),
                                  keep<Arch>(chosen, p_all.z)};
        const Batch<Arch> q[3] = {keep<Arch>(chosen, q_all.x), keep<Arch>(chosen, q_all.y),
                                  keep<Arch>(chosen, q_all.z)};
        weight.add(k, w);
        for (int a = 0, s = 0; a < 3; ++a) {
          const Batch<Arch> wp = w * p[a];
          const Batch<Arch> wq = w * q[a];
          source[a].add(k, wp);
          target[a].add(k, wq);
          for (int b = 0; b < 3; ++b) cross[3 * a + b].add(k, wq * p[b]);
          for (int b = a; b < 3; ++b, ++s) scatter[s].add(k, wp * p[b]);
        }
        if constexpr (kWithResidual) residual.add(k, w * keep<Arch>(chosen, weights.squared_residual));
      }
    }
    moments->weight += static_cast<double>(weight.total());
    for (int k = 0; k < 3; ++k) moments->source[k] += static_cast<double>(source[k].total());
    for (int k = 0; k < 3; ++k) moments->target[k] += static_cast<double>(target[k].total());
    for (int k = 0; k < 9; ++k) moments->cross[k] += static_cast<double>(cross[k].total());
    for (int k = 0; k < 6; ++k) moments->source_scatter[k] += static_cast<double>(scatter[k].total());
    if constexpr (kWithResidual) moments->residual += static_cast<double>(residual.total());
  }
}

template <typename Arch>
void weighted_moments(const RawView& view, const float* weights, RigidMoments* moments) {
  const auto weigh = [&view, weights](std::size_t j, const Vec3<Arch>&, const Vec3<Arch>&) {
    const std::size_t left = view.size > j ? view.size - j : 0;
    const std::uint64_t present = left < 64 ? (std::uint64_t{1} << left) - 1 : ~std::uint64_t{0};
    return Weights<Arch>{mask_of(present, Arch{}), Batch<Arch>::load_aligned(weights + j), Batch<Arch>(0.0f)};
  };
  sum_moments<Arch, false>(view, weigh, moments);
}

template <typename Arch>
void subset_moments(const RawView& view, const std::uint64_t* bits, RigidMoments* moments) {
  const auto weigh = [bits](std::size_t j, const Vec3<Arch>&, const Vec3<Arch>&) {
    return Weights<Arch>{mask_of(bits[j / 64] >> (j % 64), Arch{}), Batch<Arch>(1.0f), Batch<Arch>(0.0f)};
  };
  sum_moments<Arch, false>(view, weigh, moments);
}

template <typename Arch, WeightFunction kFunction>
inline Batch<Arch> robust_weight(const RawWeight& weight, const Batch<Arch>& squared) {
  if constexpr (kFunction == WeightFunction::cauchy) {
    return divide(Batch<Arch>(1.0f), 1.0f + squared * weight.inverse_squared_scale);
  } else if constexpr (kFunction == WeightFunction::student_uniform) {
    const Batch<Arch> y = 1.0f + squared * weight.inverse_squared_scale;
    Batch<Arch> power = y;
    for (std::uint32_t s = 0; s < weight.squarings; ++s) power = power * power;
    return divide(Batch<Arch>(1.0f), y * (1.0f + weight.odds * power));
  } else {
    return Batch<Arch>(1.0f);
  }
}

template <typename Arch, WeightFunction kFunction>
inline void sum_robust_moments(const RawView& view, const WorkingPose& pose, const RawWeight& weight,
                               RigidMoments* moments) {
  const Residual<Arch> residual(pose);
  const Batch<Arch> squared_cutoff(weight.squared_cutoff);
  const auto weigh = [&](std::size_t, const Vec3<Arch>& p, const Vec3<Arch>& q) {
    const Batch<Arch> squared = residual(p, q);
    return Weights<Arch>{squared < squared_cutoff, robust_weight<Arch, kFunction>(weight, squared), squared};
  };
  sum_moments<Arch, true>(view, weigh, moments);
}

template <typename Arch>
void robust_moments(const RawView& view, const WorkingPose& pose, const RawWeight& weight, RigidMoments* moments) {
  switch (weight.function) {
    case WeightFunction::truncated:
      return sum_robust_moments<Arch, WeightFunction::truncated>(view, pose, weight, moments);
    case WeightFunction::cauchy:
      return sum_robust_moments<Arch, WeightFunction::cauchy>(view, pose, weight, moments);
    case WeightFunction::student_uniform:
      return sum_robust_moments<Arch, WeightFunction::student_uniform>(view, pose, weight, moments);
  }
}

}  // namespace consimd::detail
