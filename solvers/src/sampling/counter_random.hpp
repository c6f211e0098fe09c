// Random numbers as a pure function of (seed, stage, hypothesis): the same draws whatever thread evaluates a
// hypothesis.
#pragma once

#include <Random123/philox.h>

#include <cstdint>

namespace consimd::detail {

/// Which part of a solver draws: keeps the streams of the stages apart.
enum class RandomStage : std::uint32_t {
  one_point = 1,
  two_point = 2,
  three_point = 3,
  permutation = 4,
  background = 5,
  pairing = 6,
  matrix_sample = 7,
  sparsification = 8,
  scale_voters = 9,
  repeated_points = 10
};

class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, RandomStage stage, std::uint64_t hypothesis) noexcept
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{{0, static_cast<std::uint32_t>(stage), static_cast<std::uint32_t>(hypothesis),
                  static_cast<std::uint32_t>(hypothesis >> 32)}} {}

  std::uint32_t operator()() noexcept {
    if (next_ == 4) {
      block_ = r123::Philox4x32()(counter_, key_);
      ++counter_[0];
      next_ = 0;
    }
    return block_[next_++];
  }

  /// Uniform in [0, n), n > 0. Multiply-shift: its bias, below n / 2^32, is far under what a solver could notice.
  std::uint32_t below(std::uint32_t n) noexcept {
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>((*this)()) * n) >> 32);
  }

 private:
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
  r123::Philox4x32::ctr_type block_{};
  unsigned next_ = 4;
};

}  // namespace consimd::detail
