// The number of false poses: from a pose's supporters and what chance gives.
#pragma once

#include <array>
#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/supporters.hpp"

namespace consimd::detail {

/// Supporters closer than this, in noise bounds, count once; where outliers move as one over longer distances, those.
inline constexpr double kLeastRadius = 1.75;
inline constexpr double kLargestRadius = 3.0;
/// Sources closer than this, in noise bounds, tell of the same place.
inline constexpr double kNearMisses = 4.0;

/// Chances at each of the tested bounds.
struct Chances {
  std::array<double, kTestedBounds.size()> support{};  ///< that a pose takes a source to the target of another row
  std::array<double, kTestedBounds.size()> length{};   ///< that two correspondences agree in length
};

/// A pose that is fitted to n supporters comes closer to them than it does to rows that it knows nothing of. By so many
/// times: with 6 parameters and 3 n coordinates the mean square of residuals is 1 - 2 / n of the variance, and that of
/// a new row's is 1 + 2 / n of it.
double fit_gain(const Supports& supports);

/// Supporters of a pose that count where those closer to one another than kLargestRadius count once. noise_bound:
/// caller's unit.
double independent_support(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound);

/// What pairing at random gives. `pairs`: whose lengths are compared, to within twice `noise_bound`; `shifts`: pairings
/// of all correspondences, of which those within `reach` are hits. `matched` at the pose are no hit. noise_bound,
/// reach: caller's unit.
Chances random_chances(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double reach,
                       std::uint32_t pairs, std::uint32_t shifts, RareHits rare, const MatchedPoints& matched);

/// ln P[Binomial(n, p) >= k] for k above the mean, by the exponential bound of Chernoff with the factor of Bahadur and
/// Rao; 0 below it.
double log_binomial_tail(double n, double k, double p);

/// ln of the number of false poses that the supporters at the most telling bound leave, of `size` correspondences.
double log_false_poses(double size, const Supports& supports, const Chances& chances);

}  // namespace consimd::detail
