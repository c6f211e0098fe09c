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

/// Bits of the correspondences from `begin` + `first`, a multiple of the width, to `begin` + `end` that pass, in their
/// places in the word. What follows up to a full register is padding.
template <typename Arch, typename Test>
inline std::uint64_t test_part_of_word(const RawView& view, const Test& test, std::size_t begin, std::size_t first,
                                       std::size_t end) {
  std::uint64_t word = 0;
  for (std::size_t k = first; k < end; k += kWidth<Arch>) {
    const Vec3<Arch> source = load<Arch>(view.source, begin + k);
    const Vec3<Arch> target = load<Arch>(view.target, begin + k);
    word |= bitmask(passing<Arch>(test, source, target, 0)) << k;
  }
  return word;
}

template <typename Arch>
inline std::size_t least(std::size_t a, std::size_t b) {
  return a < b ? a : b;
}

/// Tests the 64 rows of a word of rows against the words [left, right): all of them right of the diagonal, of the word
/// on the diagonal what follows the row's own register, and nothing left of it. Degrees leave the word on the diagonal
/// out, which is not whole yet. `tiles` gets what the rows get.
template <typename Arch, typename Test, typename Bounds>
void test_rows(const RawView& view, Bounds bounds, std::size_t row_word, std::size_t left, std::size_t right,
               std::uint64_t* bits, std::uint32_t* degrees, BitTiles& tiles) {
  const std::size_t words = view.padded / 64;
  // The last word is taken up to where its padding begins: small sets have much.
  const std::size_t last_end = view.size - (words - 1) * 64;
  for (std::size_t i = row_word * 64; i < least<Arch>(row_word * 64 + 64, view.size); ++i) {
    const Test test[] = {{view, static_cast<std::uint32_t>(i), bounds}};
    const auto found = [&](std::size_t word, std::uint64_t consistent) {
      bits[i * words + word] = consistent;
      tiles.rows[i % 64][word - left] = consistent;
      return popcount<Arch>(consistent);
    };
    std::size_t word = left;
    if (left <= row_word) {
      const std::size_t first = i % 64 / kWidth<Arch> * kWidth<Arch>;
      const std::size_t end = row_word + 1 < words ? 64 : last_end;
      found(row_word, test_part_of_word<Arch>(view, test[0], row_word * 64, first, end));
      word = row_word + 1;
    }
    std::uint32_t degree = 0;
    for (; word < least<Arch>(right, words - 1); ++word) {
      std::uint64_t consistent[1];
      test_words<Arch>(view, test, word * 64, consistent);
      degree += found(word, consistent[0]);
    }
    if (word < right) degree += found(word, test_part_of_word<Arch>(view, test[0], word * 64, 0, last_end));
    degrees[i] += degree;
  }
}

/// Tests what is above the diagonal; the rest is its transpose. Works through squares of kTiles x kTiles tiles, so that
/// what is mirrored is written in whole cache lines.
template <typename Arch, typename Test, typename Bounds>
void consistency_matrix(const RawView& view, Bounds bounds, std::uint64_t* bits, std::uint32_t* degrees) {
  const std::size_t size = view.size;
  const std::size_t words = view.padded / 64;
  for (std::size_t i = 0; i < size; ++i) degrees[i] = 0;
  for (std::size_t top = 0; top < words; top += kTiles) {
    const std::size_t bottom = least<Arch>(top + kTiles, words);
    for (std::size_t left = top; left < words; left += kTiles) {
      const std::size_t right = least<Arch>(left + kTiles, words);
      BitTiles square[kTiles];  // what is not written does not reach what is read
      for (std::size_t row_word = top; row_word < bottom; ++row_word) {
        BitTiles& tiles = square[row_word - top];
        test_rows<Arch, Test>(view, bounds, row_word, left, right, bits, degrees, tiles);
        for (std::size_t i = size; i < (row_word + 1) * 64; ++i) tiles.rows[i % 64][row_word - left] = 0;
        transpose<Arch>(tiles);
      }
      for (std::size_t word = left; word < right; ++word) {
        for (std::size_t j = word * 64; j < least<Arch>(word * 64 + 64, size); ++j) {
          std::uint64_t* const row = bits + j * words;
          std::uint32_t degree = 0;
          for (std::size_t row_word = top; row_word < least<Arch>(word, bottom); ++row_word) {
            row[row_word] = square[row_word - top].rows[j % 64][word - left];
            degree += popcount<Arch>(row[row_word]);
          }
          if (left == top) {
            row[word] |= square[word - top].rows[j % 64][word - left];
            degree += popcount<Arch>(row[word]);
          }
          degrees[j] += degree;
        }
      }
    }
  }
}

template <typename Arch>
std::uint32_t and_popcount(const std::uint64_t* a, const std::uint64_t* b, std::size_t words) {
  return common_bits(a, b, words, Arch{});
}

template <typename Arch>
void and_popcount_rows(const std::uint64_t* matrix, std::size_t words, const std::uint64_t* set,
                       const std::uint32_t* rows, std::size_t n, std::uint32_t* counts) {
  for (std::size_t r = 0; r < n; ++r) counts[r] = common_bits(matrix + rows[r] * words, set, words, Arch{});
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
      for (std::size_t r = 0; r < kRows; ++r) sum[r].add(k, keep<Arch>(mask_of(bits[r] >> k, Arch{}), terms));
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
