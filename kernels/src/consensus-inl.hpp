// Runs a consensus test, one per hypothesis, over all correspondences. A test is a functor built from a hypothesis;
// given the source and target points of as many correspondences as a register holds, it returns the mask of those that
// pass. Points of NaN must fail.
#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

/// Bits of the 64 correspondences from `begin` on.
template <typename Arch, typename Test>
inline std::uint64_t test_word(const RawView& view, const Test& test, std::size_t begin) {
  std::uint64_t word = 0;
  for (std::size_t k = 0; k < 64; k += kWidth<Arch>) {
    word |= bitmask(test(load<Arch>(view.source, begin + k), load<Arch>(view.target, begin + k))) << k;
  }
  return word;
}

/// counts[h] = passes of Test(view, hypotheses[h], bound); row h of `bits`, unless null, tells which.
template <typename Arch, typename Test, typename Hypothesis>
void run_consensus(const RawView& view, const Hypothesis* hypotheses, std::size_t n, float bound, std::uint64_t* bits,
                   std::uint32_t* counts) {
  // All hypotheses meet one block before the next: a block of six arrays, 24 KiB, stays in the first-level cache.
  constexpr std::size_t kBlockWords = 16;
  const std::size_t words = view.padded / 64;
  for (std::size_t h = 0; h < n; ++h) counts[h] = 0;
  for (std::size_t begin = 0; begin < words; begin += kBlockWords) {
    const std::size_t end = begin + kBlockWords < words ? begin + kBlockWords : words;
    for (std::size_t h = 0; h < n; ++h) {
      const Test test(view, hypotheses[h], bound);
      std::uint32_t count = 0;
      for (std::size_t w = begin; w < end; ++w) {
        const std::uint64_t word = test_word<Arch>(view, test, w * 64);
        count += popcount<Arch>(word);
        if (bits != nullptr) bits[h * words + w] = word;
      }
      counts[h] += count;
    }
  }
}

}  // namespace consimd::detail
