// What makes one hypothesis better than another.
#pragma once

#include <cstdint>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

enum class PoseRanking : std::uint8_t {
  inlier_count,     ///< number of residuals below the noise bound
  truncated_score,  ///< sum(1 - r^2 / noise_bound^2) over these, the MSAC score
};

}  // namespace consimd
