// All that the vector bodies use of xsimd, and the few operations that its versions, 8.1 to 14, lack, get wrong or
// disagree on.
// Only ISA-specific sources include this. Everything here is a template over, or takes, a type of one architecture, so
// no symbol compiled for a wide instruction set can be picked by the linker for a narrow one.
#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/batch.hpp"

// What each instruction set does in its own way, overloads in a file of its own:
//   larger(a, b)         of floats: a > b ? a : b, so b where either is NaN; versions of xsimd differ in what theirs do
//                        with NaN
//   smaller(a, b)        likewise
//   bitmask(mask)        bit l tells lane l
//   mask_of(bits, Arch)  the inverse, from the lowest bits of a word
//   join(lanes)          sum of the lanes: l + width/2 onto l, and so on down
//   pair_products(a, b)  of lanes of two 16-bit whole numbers: the sum of their two products
// It may replace any of the templates that follow them here.
#if XSIMD_WITH_AVX512BW
#include "simd/avx512.hpp"
#elif XSIMD_WITH_AVX2
#include "simd/avx2.hpp"
#elif XSIMD_WITH_NEON64
#include "simd/neon.hpp"
#else
#include "simd/sse2.hpp"
#endif

namespace consimd::detail {

/// The larger of two whole numbers.
template <typename Arch>
inline IntBatch<Arch> larger(const IntBatch<Arch>& a, const IntBatch<Arch>& b) {
  return xsimd::max(a, b);
}

/// x < a or x < b.
template <typename Arch>
inline Mask<Arch> below_larger(const Batch<Arch>& x, const Batch<Arch>& a, const Batch<Arch>& b) {
  return x < larger(a, b);
}

/// a - b, which `by_multiplier` lets an instruction set compute as a product less b.
template <typename Arch>
inline Batch<Arch> difference(const Batch<Arch>& a, const Batch<Arch>& b, bool /*by_multiplier*/ = true) {
  return a - b;
}

/// Correctly rounded.
template <typename Arch>
inline Batch<Arch> divide(const Batch<Arch>& a, const Batch<Arch>& b) {
  return a / b;
}

/// Correctly rounded.
template <typename Arch>
inline Batch<Arch> square_root(const Batch<Arch>& a) {
  return xsimd::sqrt(a);
}

/// sum + term, where `sum` is an accumulator that stays in its register.
template <typename Arch>
inline IntBatch<Arch> sum_in_place(const IntBatch<Arch>& sum, const IntBatch<Arch>& term) {
  return sum + term;
}

/// How many bits are set in both of two arrays.
template <typename Arch>
inline std::uint32_t common_bits(const std::uint64_t* a, const std::uint64_t* b, std::size_t words, Arch /*tag*/) {
  std::uint32_t count = 0;
  for (std::size_t word = 0; word < words; ++word) count += popcount<Arch>(a[word] & b[word]);
  return count;
}

/// from[at[0]], from[at[1]], ...
template <typename Arch>
inline Batch<Arch> gather(const float* from, const std::uint32_t* at, Arch /*tag*/) {
  alignas(64) float lanes[kWidth<Arch>];
  for (std::size_t l = 0; l < kWidth<Arch>; ++l) lanes[l] = from[at[l]];
  return Batch<Arch>::load_aligned(lanes);
}

/// Stores the lanes l whose bits are set, and the numbers first + l, side by side, and anything behind them as far as a
/// register reaches.
template <typename Arch>
inline void store_chosen(const Batch<Arch>& values, std::uint32_t first, std::uint64_t bits, float* chosen,
                         std::uint32_t* indices) {
  alignas(64) float lanes[kWidth<Arch>];
  values.store_aligned(lanes);
  std::size_t count = 0;
  for (std::uint32_t l = 0; l < kWidth<Arch>; ++l) {
    chosen[count] = lanes[l];
    indices[count] = first + l;
    count += bits >> l & 1u;
  }
}

/// `value` where the mask is set, else 0.
template <typename Arch>
inline Batch<Arch> keep(const Mask<Arch>& mask, const Batch<Arch>& value) {
  return xsimd::select(mask, value, Batch<Arch>(0.0f));
}

template <typename Arch>
struct Vec3 {
  Batch<Arch> x, y, z;
};

template <typename Arch>
inline Vec3<Arch> operator-(const Vec3<Arch>& a, const Vec3<Arch>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <typename Arch>
inline Vec3<Arch> operator+(const Vec3<Arch>& a, const Vec3<Arch>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <typename Arch>
inline Vec3<Arch> operator*(const Batch<Arch>& s, const Vec3<Arch>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <typename Arch>
inline Batch<Arch> dot(const Vec3<Arch>& a, const Vec3<Arch>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <typename Arch>
inline Vec3<Arch> cross(const Vec3<Arch>& a, const Vec3<Arch>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Points j .. j + width - 1 of an array of points.
template <typename Arch>
inline Vec3<Arch> load(const float* const points[3], std::size_t j) {
  return {Batch<Arch>::load_aligned(points[0] + j), Batch<Arch>::load_aligned(points[1] + j),
          Batch<Arch>::load_aligned(points[2] + j)};
}

/// Point j in every lane.
template <typename Arch>
inline Vec3<Arch> broadcast(const float* const points[3], std::size_t j) {
  return {Batch<Arch>(points[0][j]), Batch<Arch>(points[1][j]), Batch<Arch>(points[2][j])};
}

/// Sum of terms 0, 1, 2, ... in 16 interleaved partial sums, whatever the width of a register, joined pairwise in one
/// order.
template <typename Arch>
class InterleavedSum {
 public:
  InterleavedSum() {
    for (auto& lanes : lanes_) lanes = Batch<Arch>(0.0f);
  }

  /// Adds terms j .. j + width - 1; j is a multiple of the width.
  void add(std::size_t j, const Batch<Arch>& terms) {
    auto& lanes = lanes_[j / kWidth<Arch> % kRegisters];
    lanes = lanes + terms;
  }

  float total() const {
    Batch<Arch> sum[kRegisters];
    for (std::size_t r = 0; r < kRegisters; ++r) sum[r] = lanes_[r];
    for (std::size_t half = kRegisters / 2; half > 0; half /= 2) {
      for (std::size_t r = 0; r < half; ++r) sum[r] = sum[r] + sum[r + half];
    }
    return join(sum[0]);
  }

 private:
  static constexpr std::size_t kRegisters = 16 / kWidth<Arch>;
  Batch<Arch> lanes_[kRegisters];
};

}  // namespace consimd::detail
