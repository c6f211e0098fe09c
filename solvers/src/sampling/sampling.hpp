// Stopping rule and draws that the three RANSAC stages share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "sampling/counter_random.hpp"

namespace consimd::detail {

/// Hypotheses evaluated together. The stages walk through a batch in order and stop inside it, so the result does not
/// depend on this size.
inline constexpr std::uint32_t kBatch = 32;

/// Eq. (ransac-nt): draws until one sample of `sample_size` has been all inliers with probability `confidence`, for an
/// inlier share in [0, 1].
inline std::uint64_t iterations_needed(double confidence, double inlier_share, int sample_size) {
  double good = 1.0;
  for (int k = 0; k < sample_size; ++k) good *= inlier_share;
  if (good >= 1.0) return 1;
  const double needed = std::ceil(elementary::log1p(-confidence) / elementary::log1p(-good));
  constexpr double kNever = 1e18;
  return needed < kNever ? static_cast<std::uint64_t>(needed) : static_cast<std::uint64_t>(kNever);
}

/// Two different positions below n >= 2.
inline IndexPair draw_pair(CounterRandom& random, std::uint32_t n) {
  IndexPair pair{random.below(n), random.below(n - 1)};
  if (pair.second >= pair.first) ++pair.second;
  return pair;
}

/// Three different positions below n >= 3.
inline IndexTriple draw_triple(CounterRandom& random, std::uint32_t n) {
  const IndexPair pair = draw_pair(random, n);
  IndexTriple triple{pair.first, pair.second, random.below(n - 2)};
  if (triple.third >= std::min(pair.first, pair.second)) ++triple.third;
  if (triple.third >= std::max(pair.first, pair.second)) ++triple.third;
  return triple;
}

}  // namespace consimd::detail
