// All that the vector bodies use of xsimd, and the few operations that its versions, 8.1 to 14, lack, get wrong or
// disagree on.
// Only ISA-specific sources include this. Everything here is a template over, or takes, a type of one architecture, so
// no symbol compiled for a wide instruction set can be picked by the linker for a narrow one.
#pragma once

#include <cstddef>
#include <cstdint>

#include <xsimd/xsimd.hpp>

namespace consimd::detail {

template <typename Arch>
using Batch = xsimd::batch<float, Arch>;
template <typename Arch>
using Mask = xsimd::batch_bool<float, Arch>;

template <typename Arch>
inline constexpr std::size_t kWidth = Batch<Arch>::size;

/// a > b ? a : b, so b where either is NaN; `smaller` likewise. Versions of xsimd differ in what theirs do with NaN.
template <typename Arch>
inline Batch<Arch> larger(const Batch<Arch>& a, const Batch<Arch>& b) {
#if XSIMD_WITH_AVX512BW
  return _mm512_max_ps(a, b);
#elif XSIMD_WITH_AVX2
  return _mm256_max_ps(a, b);
#elif XSIMD_WITH_NEON64
  return xsimd::select(a > b, a, b);
#else
  return _mm_max_ps(a, b);
#endif
}

template <typename Arch>
inline Batch<Arch> smaller(const Batch<Arch>& a, const Batch<Arch>& b) {
#if XSIMD_WITH_AVX512BW
  return _mm512_min_ps(a, b);
#elif XSIMD_WITH_AVX2
  return _mm256_min_ps(a, b);
#elif XSIMD_WITH_NEON64
  return xsimd::select(a < b, a, b);
#else
  return _mm_min_ps(a, b);
#endif
}

/// x < a or x < b. With AVX-512 a second comparison is cheaper than a maximum, which competes with additions for a port
/// of Zen 4.
template <typename Arch>
inline Mask<Arch> below_larger(const Batch<Arch>& x, const Batch<Arch>& a, const Batch<Arch>& b) {
#if XSIMD_WITH_AVX512BW
  return (x < a) | (x < b);
#else
  return x < larger(a, b);
#endif
}

/// a - b. With AVX-512, if so told, as a * 1 - b, which rounds the same: Zen 4 has two ports for additions and two
/// others for products, and the busier two set the pace.
template <typename Arch>
inline Batch<Arch> difference(const Batch<Arch>& a, const Batch<Arch>& b, [[maybe_unused]] bool by_multiplier = true) {
#if XSIMD_WITH_AVX512BW
  if (by_multiplier) return _mm512_fmsub_ps(a, _mm512_set1_ps(1.0f), b);
#endif
  return a - b;
}

/// Correctly rounded a / b and sqrt(a): those of xsimd 8.1 are estimates on NEON.
template <typename Arch>
inline Batch<Arch> divide(const Batch<Arch>& a, const Batch<Arch>& b) {
#if XSIMD_WITH_NEON64
  return vdivq_f32(a, b);
#else
  return a / b;
#endif
}

template <typename Arch>
inline Batch<Arch> square_root(const Batch<Arch>& a) {
#if XSIMD_WITH_NEON64
  return vsqrtq_f32(a);
#else
  return xsimd::sqrt(a);
#endif
}

/// `value` where the mask is set, else 0.
template <typename Arch>
inline Batch<Arch> keep(const Mask<Arch>& mask, const Batch<Arch>& value) {
  return xsimd::select(mask, value, Batch<Arch>(0.0f));
}

template <typename Arch>
inline std::uint32_t popcount(std::uint64_t bits) {
  return static_cast<std::uint32_t>(__builtin_popcountll(bits));
}

// What each architecture does in its own way:
//   bitmask       bit l tells lane l
//   mask_of       the inverse, from the lowest bits of a word
//   join          sum of the lanes: l + width/2 onto l, and so on down
//   and_popcount  bits set in both of two arrays
#if XSIMD_WITH_AVX512BW

inline std::uint64_t bitmask(const Mask<xsimd::avx512bw>& mask) { return static_cast<__mmask16>(mask.data); }

template <typename Arch>
inline Mask<Arch> mask_of(std::uint64_t bits) {
  return Mask<Arch>(static_cast<__mmask16>(bits));
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

template <typename Arch>
[[gnu::always_inline]] inline std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b,
                                                         std::size_t words) {
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

#elif XSIMD_WITH_AVX2

inline std::uint64_t bitmask(const Mask<xsimd::avx2>& mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(mask.data));
}

template <typename Arch>
inline Mask<Arch> mask_of(std::uint64_t bits) {
  const __m256i lane_bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  const __m256i chosen = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(bits)), lane_bits);
  return Mask<Arch>(_mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, lane_bits)));
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

template <typename Arch>
[[gnu::always_inline]] inline std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b,
                                                         std::size_t words) {
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
  for (; word < words; ++word) count += popcount<Arch>(a[word] & b[word]);
  return count;
}

#elif XSIMD_WITH_NEON64

inline std::uint64_t bitmask(const Mask<xsimd::neon64>& mask) {
  const uint32x4_t lane_bits = {1, 2, 4, 8};
  return vaddvq_u32(vandq_u32(mask.data, lane_bits));
}

template <typename Arch>
inline Mask<Arch> mask_of(std::uint64_t bits) {
  const uint32x4_t lane_bits = {1, 2, 4, 8};
  return Mask<Arch>(vtstq_u32(vdupq_n_u32(static_cast<std::uint32_t>(bits)), lane_bits));
}

inline float join(const Batch<xsimd::neon64>& lanes) {
  return vpadds_f32(vadd_f32(vget_low_f32(lanes), vget_high_f32(lanes)));
}

#elif XSIMD_WITH_SSE2

inline std::uint64_t bitmask(const Mask<xsimd::sse2>& mask) {
  return static_cast<std::uint32_t>(_mm_movemask_ps(mask.data));
}

template <typename Arch>
inline Mask<Arch> mask_of(std::uint64_t bits) {
  const __m128i lane_bits = _mm_setr_epi32(1, 2, 4, 8);
  const __m128i chosen = _mm_and_si128(_mm_set1_epi32(static_cast<int>(bits)), lane_bits);
  return Mask<Arch>(_mm_castsi128_ps(_mm_cmpeq_epi32(chosen, lane_bits)));
}

inline float join(const Batch<xsimd::sse2>& lanes) {
  const __m128 two = _mm_add_ps(lanes, _mm_movehl_ps(lanes, lanes));
  return _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps(two, two, 1)));
}

#endif

#if !XSIMD_WITH_AVX512BW && !XSIMD_WITH_AVX2

template <typename Arch>
inline std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  std::uint32_t count = 0;
  for (std::size_t word = 0; word < words; ++word) count += popcount<Arch>(a[word] & b[word]);
  return count;
}

#endif

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
