// Adaptive voting: robust estimation of one number from measurements of bounded error.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

struct AdaptiveVote {
  double value = 0.0;                    ///< weighted mean of the consensus
  double cost = 0.0;                     ///< sum over all measurements of min((v - value)^2 / bound^2, 1)
  std::vector<std::uint32_t> consensus;  ///< measurements whose intervals hold a common point, ascending
};

/// The exact minimiser of the truncated least squares cost (H. Yang, J. Shi, L. Carlone, "TEASER: Fast and Certifiable
/// Point Cloud Registration", T-RO 2021, algorithm 1). Between neighbouring end points of the intervals v -+ bound the
/// set of intervals that hold a point does not change; each set gives its mean with weights 1 / bound^2, the one of
/// least cost is taken, the lowest value among equals. values, bounds: n, finite, bounds > 0; in O(n log n). Without
/// measurements all is 0. Throws std::invalid_argument on mismatched sizes or a bad bound or value.
[[nodiscard]] AdaptiveVote adaptive_voting(std::span<const double> values, std::span<const double> bounds);

}  // namespace consimd
