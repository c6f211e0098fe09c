#pragma once

#include "consensus-inl.hpp"
#include "kernel_table.hpp"
#include "length_consistency-inl.hpp"
#include "simd.hpp"

namespace consimd::detail {

constexpr std::size_t kTiles = 8;

/// Tiles of 64 x 64 bits side by side: word t of row i is row i of tile t.
struct BitTiles {
  alignas(64) std::uint64_t rows[64][kTiles];
};

/// Exchanges the off-diagonal blocks of kSize x kSize bits of every tile; kLowBits are the columns whose index has bit
/// kSize clear.
template <typename Arch, std::size_t kSize, std::uint64_t kLowBits>
inline void exchange_blocks(BitTiles& tiles) {
  using Words = xsimd::batch<std::uint64_t, Arch>;
  for (std::size_t block = 0; block < 64; block += 2 * kSize) {
    for (std::size_t i = block; i < block + kSize; ++i) {
      for (std::size_t t = 0; t < kTiles; t += Words::size) {
        const Words upper = Words::load_aligned(&tiles.rows[i][t]);
        const Words lower = Words::load_aligned(&tiles.rows[i + kSize][t]);
        const Words exchanged = ((upper >> static_cast<int>(kSize)) ^ lower) & Words(kLowBits);
        (lower ^ exchanged).store_aligned(&tiles.rows[i + kSize][t]);
        (upper ^ (exchanged << static_cast<int>(kSize))).store_aligned(&tiles.rows[i][t]);
      }
    }
  }
}

/// Transposes every tile in place.
template <typename Arch>
inline void transpose(BitTiles& tiles) {
  exchange_blocks<Arch, 1, 0x5555555555555555>(tiles);
  exchange_blocks<Arch, 2, 0x3333333333333333>(tiles);
  exchange_blocks<Arch, 4, 0x0f0f0f0f0f0f0f0f>(tiles);
  exchange_blocks<Arch, 8, 0x00ff00ff00ff00ff>(tiles);
  exchange_blocks<Arch, 16, 0x0000ffff0000ffff>(tiles);
  exchange_blocks<Arch, 32, 0x00000000ffffffff>(tiles);
}

/// Tests the tiles on and above the diagonal; those below are their transposes. Works through squares of kTiles x
/// kTiles tiles, so that what is mirrored is written in whole cache lines.
template <typename Arch, typename Test, typename Bounds>
void consistency_matrix(const RawView& view, Bounds bounds, std::uint64_t* bits, std::uint32_t* degrees) {
  const std::size_t size = view.size;
  const std::size_t words = view.padded / 64;
  const auto end_of = [](std::size_t begin, std::size_t length, std::size_t limit) {
    return begin + length < limit ? begin + length : limit;
  };
  for (std::size_t i = 0; i < size; ++i) degrees[i] = 0;
  for (std::size_t top = 0; top < words; top += kTiles) {
    const std::size_t bottom = end_of(top, kTiles, words);
    for (std::size_t left = top; left < words; left += kTiles) {
      const std::size_t right = end_of(left, kTiles, words);
      BitTiles square[kTiles] = {};
      for (std::size_t row_word = top; row_word < bottom; ++row_word) {
        BitTiles& tiles = square[row_word - top];
        const std::size_t first = left == top ? row_word : left;
        for (std::size_t i = row_word * 64; i < end_of(row_word * 64, 64, size); ++i) {
          const Test test[] = {{view, static_cast<std::uint32_t>(i), bounds}};
          std::uint32_t degree = 0;
          for (std::size_t word = first; word < right; ++word) {
            std::uint64_t consistent[1];
            test_words<Arch>(view, test, word * 64, consistent);
            bits[i * words + word] = consistent[0];
            tiles.rows[i % 64][word - left] = consistent[0];
            degree += popcount<Arch>(consistent[0]);
          }
          degrees[i] += degree;
        }
        transpose<Arch>(tiles);
      }
      for (std::size_t word = left; word < right; ++word) {
        const std::size_t mirrored_end = word < bottom ? word : bottom;
        for (std::size_t j = word * 64; j < end_of(word * 64, 64, size); ++j) {
          std::uint32_t degree = 0;
          for (std::size_t row_word = top; row_word < mirrored_end; ++row_word) {
            const std::uint64_t consistent = square[row_word - top].rows[j % 64][word - left];
            bits[j * words + row_word] = consistent;
            degree += popcount<Arch>(consistent);
          }
          degrees[j] += degree;
        }
      }
    }
  }
}

template <typename Arch>
void and_popcount_rows(const std::uint64_t* matrix, std::size_t words, const std::uint64_t* set,
                       const std::uint32_t* rows, std::size_t n, std::uint32_t* counts) {
  for (std::size_t r = 0; r < n; ++r) counts[r] = and_popcount<Arch>(matrix + rows[r] * words, set, words);
}

/// sums[r] for kRows rows at once: what is loaded of `values` serves all, and their additions do not wait for one
/// another.
template <typename Arch, std::size_t kRows>
inline void add_masked_rows(const std::uint64_t* rows, std::size_t words, const float* values, float* sums) {
  InterleavedSum<Arch> sum[kRows];
  for (std::size_t word = 0; word < words; ++word) {
    std::uint64_t bits[kRows];
    for (std::size_t r = 0; r < kRows; ++r) bits[r] = rows[r * words + word];
    for (std::size_t k = 0; k < 64; k += kWidth<Arch>) {
      const Batch<Arch> terms = Batch<Arch>::load_unaligned(values + word * 64 + k);
      for (std::size_t r = 0; r < kRows; ++r) sum[r].add(k, keep<Arch>(mask_of<Arch>(bits[r] >> k), terms));
    }
  }
  for (std::size_t r = 0; r < kRows; ++r) sums[r] = sum[r].total();
}

template <typename Arch>
void masked_row_sums(const std::uint64_t* rows, std::size_t words, std::size_t n, const float* values, float* sums) {
  constexpr std::size_t kTogether = kWidth<Arch> / 4;
  std::size_t r = 0;
  for (; r + kTogether <= n; r += kTogether) {
    add_masked_rows<Arch, kTogether>(rows + r * words, words, values, sums + r);
  }
  for (; r < n; ++r) add_masked_rows<Arch, 1>(rows + r * words, words, values, sums + r);
}

}  // namespace consimd::detail
