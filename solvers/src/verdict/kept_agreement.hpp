// How often rows keep coordinates that a pose does not explain, and what that makes of chance.
#pragma once

#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"
#include "verdict/false_poses.hpp"

namespace consimd::detail {

/// Rows among which strata have too few alike to tell what they keep: three to each of 32 rings, say.
inline constexpr std::size_t kFewRows = 512;

/// Chances that a pose takes a source to a target if targets keep some coordinates of their sources, as they are seen
/// to, and are paired at random otherwise. One for each kind of kKept that the rows beyond kNearMisses bounds of the
/// pose keep in most cases, and more often than random pairing does,
///
///   P_rows(kept) P_random(reached | kept),
///
/// since a target that is reached has all coordinates of its source to within the residual. `at_random`: what random
/// pairing gives, which none is less than. Takes time for all pairs of kFewRows rows. noise_bound, reach: caller's
/// unit.
[[nodiscard]] std::vector<Chances> kept_chances(const Correspondences& correspondences, const WorkingPose& pose,
                                                double noise_bound, double reach, const Chances& at_random,
                                                const MatchedPoints& matched);

}  // namespace consimd::detail
