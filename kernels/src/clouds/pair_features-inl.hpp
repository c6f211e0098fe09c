#pragma once

#include "neighbourhoods-inl.hpp"

namespace consimd::detail {

/// Bits of up to 64 pairs: which features of valid pairs are negative, and which reach each of the borders.
struct FeatureBits {
  std::uint64_t valid = 0;
  std::uint64_t negative[3] = {};
  std::uint64_t reached[3][5] = {};

  template <typename Arch>
  void count(std::uint32_t* counts, Arch /*tag*/) const {
    for (std::size_t f = 0; f < 3; ++f) {
      std::uint32_t* bins = counts + f * kFeatureBins;
      std::uint64_t so_far = valid;  // that reach all borders up to here
      for (std::size_t b = 0; b <= 5; ++b) {
        const std::uint64_t further = b < 5 ? so_far & reached[f][b] : 0;
        const std::uint64_t here = so_far & ~further;
        bins[5 - b] += popcount<Arch>(here & negative[f]);
        bins[5 + b] += popcount<Arch>(here & ~negative[f]);
        so_far = further;
      }
    }
  }
};

template <typename Arch>
void pair_feature_counts(const RawPoints& cloud, std::uint32_t point, const std::uint32_t* indices, std::size_t n,
                         std::uint32_t* counts) {
  for (std::size_t bin = 0; bin < 3 * kFeatureBins; ++bin) counts[bin] = 0;
  const Vec3<Arch> p1 = broadcast<Arch>(cloud.points, point);
  const Vec3<Arch> n1 = broadcast<Arch>(cloud.normals, point);
  const Batch<Arch> zero(0.0f);
  for (std::size_t begin = 0; begin < n; begin += 64) {
    FeatureBits bits;
    for (std::size_t k = 0; k < 64 && begin + k < n; k += kWidth<Arch>) {
      const IndexBlock<Arch> block(indices, n, begin + k);
      const Vec3<Arch> d = block.points(cloud.points) - p1;
      const Vec3<Arch> n2 = block.points(cloud.normals);
      const Batch<Arch> squared_length = dot(d, d);
      const Batch<Arch> along1 = dot(n1, d);
      const Batch<Arch> along2 = dot(n2, d);
      const Batch<Arch> cosine = dot(n1, n2);
      const Batch<Arch> volume = dot(cross(n1, n2), d);
      const Mask<Arch> swapped = xsimd::abs(along1) < xsimd::abs(along2);
      const Batch<Arch> along_source = xsimd::select(swapped, zero - along2, along1);
      const Batch<Arch> along_target = xsimd::select(swapped, zero - along1, along2);
      const Batch<Arch> squared_v = squared_length - along_source * along_source;
      const Batch<Arch> turned = along_target - along_source * cosine;
      const Batch<Arch> reach = cosine * square_root(squared_v);

      const auto enter = [k](std::uint64_t& word, const Mask<Arch>& mask) { word |= bitmask(mask) << k; };
      const Mask<Arch> has_normals = cosine == cosine;  // NOLINT(misc-redundant-expression): not so of NaN
      const Mask<Arch> valid = (squared_length > zero) & (squared_v > zero) & has_normals;
      bits.valid |= (bitmask(valid) & lowest_bits<Arch>(n - begin - k)) << k;
      enter(bits.negative[0], turned < zero);
      enter(bits.negative[1], volume < zero);
      enter(bits.negative[2], along_source < zero);
      const Batch<Arch> of_turned = xsimd::abs(turned);
      const Batch<Arch> squared_volume = volume * volume;
      const Batch<Arch> squared_along = along_source * along_source;
      for (int b = 0; b < 5; ++b) {
        enter(bits.reached[0][b], kSines[b] * reach <= kCosines[b] * of_turned);
        enter(bits.reached[1][b], kSquaredShares[b] * squared_v <= squared_volume);
        enter(bits.reached[2][b], kSquaredShares[b] * squared_length <= squared_along);
      }
    }
    bits.count(counts, Arch{});
  }
}

template <typename Arch>
void weighted_histogram_sum(const float* histograms, const std::uint32_t* rows, const float* squared, std::size_t n,
                            float* sum) {
  constexpr std::size_t kRegisters = 48 / kWidth<Arch>;
  Batch<Arch> sums[kRegisters];
  for (auto& part : sums) part = Batch<Arch>(0.0f);
  for (std::size_t j = 0; j < n; ++j) {
    if (!(squared[j] > 0.0f)) continue;
    const Batch<Arch> weight(1.0f / squared[j]);
    const float* row = histograms + 48 * rows[j];
    for (std::size_t r = 0; r < kRegisters; ++r) {
      sums[r] = sums[r] + weight * Batch<Arch>::load_aligned(row + r * kWidth<Arch>);
    }
  }
  for (std::size_t r = 0; r < kRegisters; ++r) sums[r].store_aligned(sum + r * kWidth<Arch>);
}

}  // namespace consimd::detail
