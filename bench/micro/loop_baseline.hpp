// The kernels as plain loops over structure-of-arrays floats, the kind that a compiler can vectorise by itself, with
// the kernels' algebra (no inverse trigonometry, no square root where none is needed). What the layout and the algebra
// give without hand-written SIMD.
#pragma once

#include <cstddef>
#include <cstdint>

#define CONSIMD_BASELINE __attribute__((visibility("default")))

namespace consimd::bench {

/// Borrowed: coordinate a of point j is source[a][j].
struct LoopCloud {
  const float* source[3];
  const float* target[3];
  std::size_t size;
};

struct LoopPose {
  float rotation[9];  ///< row-major
  float translation[3];
};

struct LoopMoments {
  float weight, source[3], target[3], cross[9];
};

namespace loop {

CONSIMD_BASELINE std::uint32_t length_count(const LoopCloud& cloud, std::uint32_t seed, float bound);
CONSIMD_BASELINE std::uint32_t angle_count(const LoopCloud& cloud, std::uint32_t first, std::uint32_t second,
                                           float bound);
CONSIMD_BASELINE std::uint32_t alignment_count(const LoopCloud& cloud, const LoopPose& pose, float bound);
/// sum(1 - r^2 / bound^2) over r < bound.
CONSIMD_BASELINE float alignment_score(const LoopCloud& cloud, const LoopPose& pose, float bound);

// Consensus sets: passes[j] is 1 or 0, one byte for each row.
CONSIMD_BASELINE void length_set(const LoopCloud& cloud, std::uint32_t seed, float bound, std::uint8_t* passes);
CONSIMD_BASELINE void angle_set(const LoopCloud& cloud, std::uint32_t first, std::uint32_t second, float bound,
                                std::uint8_t* passes);
CONSIMD_BASELINE void alignment_set(const LoopCloud& cloud, const LoopPose& pose, float bound, std::uint8_t* passes);

CONSIMD_BASELINE LoopMoments weighted_moments(const LoopCloud& cloud, const float* weights);
/// Weights 1 / (1 + r^2 / scale^2) where r < cutoff.
CONSIMD_BASELINE LoopMoments cauchy_moments(const LoopCloud& cloud, const LoopPose& pose, float scale, float cutoff);

/// Number of bits set in both.
CONSIMD_BASELINE std::uint32_t common_count(const std::uint64_t* a, const std::uint64_t* b, std::size_t words);
/// Sum of the values at the ones of `bits`.
CONSIMD_BASELINE float masked_sum(const std::uint64_t* bits, std::size_t words, const float* values);

}  // namespace loop

namespace textbook {

// The paper's equations as printed, with their square roots, which the compiler vectorises, and inverse trigonometry,
// which it does not.
CONSIMD_BASELINE std::uint32_t length_count(const LoopCloud& cloud, std::uint32_t seed, float bound);
CONSIMD_BASELINE std::uint32_t angle_count(const LoopCloud& cloud, std::uint32_t first, std::uint32_t second,
                                           float bound);
CONSIMD_BASELINE std::uint32_t alignment_count(const LoopCloud& cloud, const LoopPose& pose, float bound);

}  // namespace textbook
}  // namespace consimd::bench
