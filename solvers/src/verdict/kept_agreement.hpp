// How often rows keep coordinates that a pose does not explain, and what that makes of chance.
#pragma once

#include <vector>

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"
#include "verdict/false_poses.hpp"

namespace consimd::detail {

/// What chance gives where a kind of coordinates is kept.
struct KeptChances {
  Chances chances;
  /// Directions along which positions are kept, source frame. One alignment brings all rows of a line along these into
  /// place: they tell of one place.
  std::vector<Eigen::Vector3f> along;
};

/// Chances that a pose takes a source to a target if targets keep some coordinates of their sources, as they are seen
/// to, and are paired at random otherwise. One for each kind of kKept that nearly all rows beyond kNearMisses bounds of
/// the pose keep, and more of them than random pairing does, and for the position along the direction that they keep
/// best, alone and with the range,
///
///   P_rows(kept) P_random(reached | kept),
///
/// since a target that is reached has all coordinates of its source to within the residual. That is taken at each of
/// kTestedBounds, and is no larger than at a wider one. All rows tell of it, where strata may have too few alike: three
/// to each of 32 rings, say. `at_random`: what random pairing gives, which none is less than. noise_bound, reach:
/// caller's unit.
[[nodiscard]] std::vector<KeptChances> kept_chances(const Correspondences& correspondences, const WorkingPose& pose,
                                                    double noise_bound, double reach, const Chances& at_random,
                                                    const MatchedPoints& matched);

}  // namespace consimd::detail
