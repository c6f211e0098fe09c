// The operations of simd.hpp in AVX2.
#pragma once

#include "batch.hpp"

namespace consimd::detail {

inline Batch<xsimd::avx2> larger(const Batch<xsimd::avx2>& a, const Batch<xsimd::avx2>& b) {
  return _mm256_max_ps(a, b);
}
inline Batch<xsimd::avx2> smaller(const Batch<xsimd::avx2>& a, const Batch<xsimd::avx2>& b) {
  return _mm256_min_ps(a, b);
}

inline std::uint64_t bitmask(const Mask<xsimd::avx2>& mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(mask.data));
}

inline Mask<xsimd::avx2> mask_of(std::uint64_t bits, xsimd::avx2) {
  const __m256i lane_bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i chosen = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), lane_bits);
  return Mask<xsimd::avx2>(_mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, lane_bits)));
}

inline float join(const Batch<xsimd::avx2>& lanes) {
  const __m128 four = _mm_add_ps(_mm256_castps256_ps128(lanes), _mm256_extractf128_ps(lanes, 1));
  const __m128 two = _mm_add_ps(four, _mm_movehl_ps(four, four));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)));
}

/// Bits set in each byte.
inline __m256i byte_popcounts(__m256i bits) {
  const __m256i bits_of_nibble =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4));
  const __m256i low_nibble = _mm256_set1_epi8(15);
  const __m256i low = _mm256_shuffle_epi8(bits_of_nibble, _mm256_and_si256(bits, low_nibble));
  const __m256i high = _mm256_shuffle_epi8(bits_of_nibble, _mm256_and_si256(_mm256_srli_epi16(bits, 4), low_nibble));
  return _mm256_add_epi8(low, high);
}

[[gnu::always_inline]] inline std::uint32_t common_bits(const std::uint64_t* a, const std::uint64_t* b,
                                                        std::size_t words, xsimd::avx2) {
  constexpr std::size_t kRun = 4 * 31;  // words whose counts a byte can sum
  __m256i sum = _mm256_setzero_si256();
  std::size_t word = 0;
  while (word + 4 <= words) {
    const std::size_t end = word + kRun < words ? word + kRun : words;
    __m256i run = _mm256_setzero_si256();
    for (; word + 4 <= end; word += 4) {
      const __m256i of_a = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(a + word));
      const __m256i of_b = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(b + word));
      run = _mm256_add_epi8(run, byte_popcounts(_mm256_and_si256(of_a, of_b)));
    }
    sum = _mm256_add_epi64(sum, _mm256_sad_epu8(run, _mm256_setzero_si256()));
  }
  const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(sum), _mm256_extracti128_si256(sum, 1));
  auto count = static_cast<std::uint32_t>(_mm_cvtsi128_si64(_mm_add_epi64(two, _mm_unpackhi_epi64(two, two))));
  for (; word < words; ++word) count += popcount<xsimd::avx2>(a[word] & b[word]);
  return count;
}

inline std::uint64_t bitmask(const IntMask<xsimd::avx2>& mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(mask.data)));
}

inline IntBatch<xsimd::avx2> pair_products(const IntBatch<xsimd::avx2>& a, const IntBatch<xsimd::avx2>& b) {
  return _mm256_madd_epi16(a, b);
}

#if defined(__GNUC__) && !defined(__clang__)
/// GCC 12 would sum into the register of `term` and copy that back: see docs/performance.md.
inline IntBatch<xsimd::avx2> sum_in_place(const IntBatch<xsimd::avx2>& sum, const IntBatch<xsimd::avx2>& term) {
  auto in_place = sum.data;
  __asm__("vpaddd %1, %0, %0" : "+x"(in_place) : "x"(term.data));
  return in_place;
}
#endif

/// Lane by lane: Zen's gather instructions take longer.
inline Batch<xsimd::avx2> gather(const float* from, const std::uint32_t* at, xsimd::avx2) {
  return _mm256_setr_ps(from[at[0]], from[at[1]], from[at[2]], from[at[3]], from[at[4]], from[at[5]], from[at[6]],
                        from[at[7]]);
}

/// Entry b: the positions of the bits set in b, ascending.
struct SetBits {
  std::uint8_t positions[256][8] = {};

  constexpr SetBits() {
    for (unsigned bits = 0; bits < 256; ++bits) {
      for (unsigned bit = 0, count = 0; bit < 8; ++bit) {
        if ((bits >> bit & 1u) != 0) positions[bits][count++] = static_cast<std::uint8_t>(bit);
      }
    }
  }
};
inline constexpr SetBits kSetBits;

inline void store_chosen(const Batch<xsimd::avx2>& values, std::uint32_t first, std::uint64_t bits, float* chosen,
                         std::uint32_t* indices) {
  const auto* entry = reinterpret_cast<const __m128i*>(kSetBits.positions[bits]);
  const __m256i positions = _mm256_cvtepu8_epi32(_mm_loadl_epi64(entry));
  _mm256_storeu_ps(chosen, _mm256_permutevar8x32_ps(values, positions));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(indices),
                      _mm256_add_epi32(positions, _mm256_set1_epi32(static_cast<int>(first))));
}

}  // namespace consimd::detail
