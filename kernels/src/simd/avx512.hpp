// The operations of simd.hpp in AVX-512 (F, CD, BW, DQ, VL).
#pragma once

#include "batch.hpp"

namespace consimd::detail {

inline Batch<xsimd::avx512bw> larger(const Batch<xsimd::avx512bw>& a, const Batch<xsimd::avx512bw>& b) {
  return _mm512_max_ps(a, b);
}
inline Batch<xsimd::avx512bw> smaller(const Batch<xsimd::avx512bw>& a, const Batch<xsimd::avx512bw>& b) {
  return _mm512_min_ps(a, b);
}

/// By a second comparison, cheaper than a maximum, which competes with additions for a port of Zen 4.
inline Mask<xsimd::avx512bw> below_larger(const Batch<xsimd::avx512bw>& x, const Batch<xsimd::avx512bw>& a,
                                          const Batch<xsimd::avx512bw>& b) {
  return (x < a) | (x < b);
}

/// If so told, as a * 1 - b, which rounds the same: Zen 4 has two ports for additions and two others for products, and
/// the busier two set the pace.
inline Batch<xsimd::avx512bw> difference(const Batch<xsimd::avx512bw>& a, const Batch<xsimd::avx512bw>& b,
                                         bool by_multiplier = true) {
  if (by_multiplier) return _mm512_fmsub_ps(a, _mm512_set1_ps(1.0f), b);
  return a - b;
}

inline std::uint64_t bitmask(const Mask<xsimd::avx512bw>& mask) { return static_cast<__mmask16>(mask.data); }

inline Mask<xsimd::avx512bw> mask_of(std::uint64_t bits, xsimd::avx512bw) {
  return Mask<xsimd::avx512bw>(static_cast<__mmask16>(bits));
}

inline float join(const Batch<xsimd::avx512bw>& lanes) {
  const __m256 eight = _mm256_add_ps(_mm512_castps512_ps256(lanes), _mm512_extractf32x8_ps(lanes, 1));
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps(eight, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
}

/// Bits set in each byte.
inline __m512i byte_popcounts(__m512i bits) {
  const __m512i bits_of_nibble = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
  const __m512i low_nibble = _mm512_set1_epi8(15);
  const __m512i low = _mm512_shuffle_epi8(bits_of_nibble, _mm512_and_si512(bits, low_nibble));
  const __m512i high = _mm512_shuffle_epi8(bits_of_nibble, _mm512_and_si512(_mm512_srli_epi16(bits, 4), low_nibble));
  return _mm512_add_epi8(low, high);
}

[[gnu::always_inline]] inline std::uint32_t common_bits(const std::uint64_t* a, const std::uint64_t* b,
                                                        std::size_t words, xsimd::avx512bw) {
  constexpr std::size_t kRun = 8 * 31;  // words whose counts a byte can sum
  __m512i sum = _mm512_setzero_si512();
  std::size_t word = 0;
  while (word < words) {
    const std::size_t end = word + kRun < words ? word + kRun : words;
    __m512i run = _mm512_setzero_si512();
    for (; word + 8 <= end; word += 8) {
      run = _mm512_add_epi8(
          run, byte_popcounts(_mm512_and_si512(_mm512_loadu_si512(a + word), _mm512_loadu_si512(b + word))));
    }
    if (word < end) {
      const auto rest = static_cast<__mmask8>((1u << (end - word)) - 1u);
      const __m512i both =
          _mm512_and_si512(_mm512_maskz_loadu_epi64(rest, a + word), _mm512_maskz_loadu_epi64(rest, b + word));
      run = _mm512_add_epi8(run, byte_popcounts(both));
      word = end;
    }
    sum = _mm512_add_epi64(sum, _mm512_sad_epu8(run, _mm512_setzero_si512()));
  }
  return static_cast<std::uint32_t>(_mm512_reduce_add_epi64(sum));
}

inline std::uint64_t bitmask(const IntMask<xsimd::avx512bw>& mask) { return static_cast<__mmask16>(mask.data); }

inline IntBatch<xsimd::avx512bw> pair_products(const IntBatch<xsimd::avx512bw>& a, const IntBatch<xsimd::avx512bw>& b) {
  return _mm512_madd_epi16(a, b);
}

inline Batch<xsimd::avx512bw> gather(const float* from, const std::uint32_t* at, xsimd::avx512bw) {
  return _mm512_i32gather_ps(_mm512_loadu_si512(at), from, sizeof(float));
}

inline void store_chosen(const Batch<xsimd::avx512bw>& values, std::uint32_t first, std::uint64_t bits, float* chosen,
                         std::uint32_t* indices) {
  const auto mask = static_cast<__mmask16>(bits);
  const __m512i lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i numbers = _mm512_add_epi32(lanes, _mm512_set1_epi32(static_cast<int>(first)));
  // By way of a register: a compressing store is slow on Zen 4.
  _mm512_storeu_ps(chosen, _mm512_maskz_compress_ps(mask, values));
  _mm512_storeu_si512(indices, _mm512_maskz_compress_epi32(mask, numbers));
}

}  // namespace consimd::detail
