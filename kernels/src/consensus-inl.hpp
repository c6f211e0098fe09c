// Runs a consensus test, one per hypothesis, over all correspondences. A test is a functor built from a hypothesis;
// given the source and target points of as many correspondences as a register holds, it returns the mask of those that
// pass. Points of NaN must fail. Its kFitTogether tells whether two of them at once are faster. A test that waits for
// roots comes in two halves, begin and finish: the next correspondences are begun before the last ones are finished.
// One that has about as much for the adders as for the multipliers takes a third argument: whether this time the latter
// do a subtraction more, every other time.
#pragma once

#include "kernel_table.hpp"
#include "simd.hpp"

namespace consimd::detail {

/// Mask of the correspondences that pass; `turn` counts the tests.
template <typename Arch, typename Test>
inline Mask<Arch> passing(const Test& test, const Vec3<Arch>& source, const Vec3<Arch>& target, std::size_t turn) {
  if constexpr (requires { test(source, target, true); }) {
    return test(source, target, turn % 2 == 0);
  } else {
    return test(source, target);
  }
}

/// words[h] = bits of the 64 correspondences from `begin` on that pass tests[h]. What is loaded serves all tests.
template <typename Arch, std::size_t kTests, typename Test>
inline void test_words(const RawView& view, const Test (&tests)[kTests], std::size_t begin,
                       std::uint64_t (&words)[kTests]) {
  for (std::size_t h = 0; h < kTests; ++h) words[h] = 0;
  if constexpr (requires { &Test::finish; }) {
    static_assert(kTests == 1);
    auto begun = tests[0].begin(load<Arch>(view.source, begin), load<Arch>(view.target, begin));
    for (std::size_t k = kWidth<Arch>; k < 64; k += kWidth<Arch>) {
      const auto next = tests[0].begin(load<Arch>(view.source, begin + k), load<Arch>(view.target, begin + k));
      words[0] |= bitmask(tests[0].finish(begun)) << (k - kWidth<Arch>);
      begun = next;
    }
    words[0] |= bitmask(tests[0].finish(begun)) << (64 - kWidth<Arch>);
  } else {
    for (std::size_t k = 0; k < 64; k += kWidth<Arch>) {
      const Vec3<Arch> source = load<Arch>(view.source, begin + k);
      const Vec3<Arch> target = load<Arch>(view.target, begin + k);
      for (std::size_t h = 0; h < kTests; ++h) {
        words[h] |= bitmask(passing<Arch>(tests[h], source, target, k / kWidth<Arch> + h)) << k;
      }
    }
  }
}

/// counts[h] += passes of tests[h] in words [begin, end); row h of `bits`, unless null, tells which.
template <typename Arch, std::size_t kTests, typename Test>
inline void run_tests(const RawView& view, const Test (&tests)[kTests], std::size_t begin, std::size_t end,
                      std::uint64_t* bits, std::uint32_t* counts) {
  std::uint32_t passes[kTests] = {};
  for (std::size_t w = begin; w < end; ++w) {
    std::uint64_t words[kTests];
    test_words<Arch>(view, tests, w * 64, words);
    for (std::size_t h = 0; h < kTests; ++h) {
      passes[h] += popcount<Arch>(words[h]);
      if (bits != nullptr) bits[h * (view.padded / 64) + w] = words[h];
    }
  }
  for (std::size_t h = 0; h < kTests; ++h) counts[h] += passes[h];
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
    const auto row = [&](std::size_t h) { return bits == nullptr ? nullptr : bits + h * words; };
    std::size_t h = 0;
    if constexpr (Test::kFitTogether) {
      for (; h + 2 <= n; h += 2) {
        const Test tests[] = {{view, hypotheses[h], bound}, {view, hypotheses[h + 1], bound}};
        run_tests<Arch>(view, tests, begin, end, row(h), counts + h);
      }
    }
    for (; h < n; ++h) {
      const Test test[] = {{view, hypotheses[h], bound}};
      run_tests<Arch>(view, test, begin, end, row(h), counts + h);
    }
  }
}

}  // namespace consimd::detail
