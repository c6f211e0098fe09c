// The operations of simd.hpp in NEON of 64-bit ARM.
#pragma once

#include "batch.hpp"

namespace consimd::detail {

inline Batch<xsimd::neon64> larger(const Batch<xsimd::neon64>& a, const Batch<xsimd::neon64>& b) {
  return xsimd::select(a > b, a, b);
}
inline Batch<xsimd::neon64> smaller(const Batch<xsimd::neon64>& a, const Batch<xsimd::neon64>& b) {
  return xsimd::select(a < b, a, b);
}

// Those of xsimd 8.1 are estimates.
inline Batch<xsimd::neon64> divide(const Batch<xsimd::neon64>& a, const Batch<xsimd::neon64>& b) {
  return vdivq_f32(a, b);
}
inline Batch<xsimd::neon64> square_root(const Batch<xsimd::neon64>& a) { return vsqrtq_f32(a); }

inline std::uint64_t bitmask(const Mask<xsimd::neon64>& mask) {
  const uint32x4_t lane_bits = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(mask.data, lane_bits));
}

inline Mask<xsimd::neon64> mask_of(std::uint64_t bits, xsimd::neon64) {
  const uint32x4_t lane_bits = {1, 2, 4, 8};
  return Mask<xsimd::neon64>(vtstq_u32(vdupq_n_u32(static_cast<std::uint32_t>(bits)), lane_bits));
}

inline float join(const Batch<xsimd::neon64>& lanes) {
  return vpadds_f32(vadd_f32(vget_low_f32(lanes), vget_high_f32(lanes)));
}

inline std::uint64_t bitmask(const IntMask<xsimd::neon64>& mask) {
  const uint32x4_t lane_bits = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(mask.data, lane_bits));
}

inline IntBatch<xsimd::neon64> pair_products(const IntBatch<xsimd::neon64>& a, const IntBatch<xsimd::neon64>& b) {
  const int16x8_t x = vreinterpretq_s16_s32(a);
  const int16x8_t y = vreinterpretq_s16_s32(b);
  return vpaddq_s32(vmull_s16(vget_low_s16(x), vget_low_s16(y)), vmull_high_s16(x, y));
}

}  // namespace consimd::detail
