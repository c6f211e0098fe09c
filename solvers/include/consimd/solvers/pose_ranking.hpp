// What makes one hypothesis better than another.
#pragma once

#include <cstdint>

#pragma GCC visibility push(default)

namespace consimd {

enum class PoseRanking : std::uint8_t {
  inlier_count,     ///< number of residuals below the noise bound
  truncated_score,  ///< sum(1 - r^2 / noise_bound^2) over these, the MSAC score
};

}  // namespace consimd

#pragma GCC visibility pop
