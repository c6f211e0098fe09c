// The operations of simd.hpp in SSE2.
#pragma once

#include "batch.hpp"

namespace consimd::detail {

inline Batch<xsimd::sse2> larger(const Batch<xsimd::sse2>& a, const Batch<xsimd::sse2>& b) { return _mm_max_ps(a, b); }
inline Batch<xsimd::sse2> smaller(const Batch<xsimd::sse2>& a, const Batch<xsimd::sse2>& b) { return _mm_min_ps(a, b); }

inline std::uint64_t bitmask(const Mask<xsimd::sse2>& mask) {
  return static_cast<std::uint32_t>(_mm_movemask_ps(mask.data));
}

inline Mask<xsimd::sse2> mask_of(std::uint64_t bits, xsimd::sse2) {
  const __m128i lane_bits = _mm_setr_epi32(1, 2, 4, 8);
  const __m128i chosen = _mm_and_si128(_mm_set1_epi32(static_cast<int>(bits)), lane_bits);
  return Mask<xsimd::sse2>(_mm_castsi128_ps(_mm_cmpeq_epi32(chosen, lane_bits)));
}

inline float join(const Batch<xsimd::sse2>& lanes) {
  const __m128 two = _mm_add_ps(lanes, _mm_movehl_ps(lanes, lanes));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

inline std::uint64_t bitmask(const IntMask<xsimd::sse2>& mask) {
  return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(mask.data)));
}

inline IntBatch<xsimd::sse2> pair_products(const IntBatch<xsimd::sse2>& a, const IntBatch<xsimd::sse2>& b) {
  return _mm_madd_epi16(a, b);
}

#if defined(__GNUC__) && !defined(__clang__)
/// GCC 12 would sum into the register of `term` and copy that back: see docs/performance.md.
inline IntBatch<xsimd::sse2> sum_in_place(const IntBatch<xsimd::sse2>& sum, const IntBatch<xsimd::sse2>& term) {
  auto in_place = sum.data;
  __asm__("paddd %1, %0" : "+x"(in_place) : "x"(term.data));
  return in_place;
}
#endif

}  // namespace consimd::detail
