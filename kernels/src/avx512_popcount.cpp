// Population counts of rows for AVX-512 processors that count bits in vectors.
#include <immintrin.h>

#include "kernel_table.hpp"

namespace consimd::detail::avx512 {
namespace {

std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  __m512i sum = _mm512_setzero_si512();
  std::size_t word = 0;
  for (; word + 8 <= words; word += 8) {
    const __m512i both = _mm512_and_si512(_mm512_loadu_si512(a + word), _mm512_loadu_si512(b + word));
    sum = _mm512_add_epi64(sum, _mm512_popcnt_epi64(both));
  }
  if (word < words) {
    const auto rest = static_cast<__mmask8>((1U << (words - word)) - 1U);
    const __m512i both =
        _mm512_and_si512(_mm512_maskz_loadu_epi64(rest, a + word), _mm512_maskz_loadu_epi64(rest, b + word));
    sum = _mm512_add_epi64(sum, _mm512_popcnt_epi64(both));
  }
  return static_cast<std::uint32_t>(_mm512_reduce_add_epi64(sum));
}

void and_popcount_rows(const std::uint64_t* matrix, std::size_t words, const std::uint64_t* set,
                       const std::uint32_t* rows, std::size_t n, std::uint32_t* counts) {
  for (std::size_t r = 0; r < n; ++r) counts[r] = and_popcount(matrix + rows[r] * words, set, words);
}

}  // namespace

void use_vector_popcount(KernelTable& table) noexcept {
  table.and_popcount = and_popcount;
  table.and_popcount_rows = and_popcount_rows;
}

}  // namespace consimd::detail::avx512
