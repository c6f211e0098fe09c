// How far a refined pose may be from the true one.
#pragma once

#include <span>

#include <consimd/features/refinement.hpp>

#include "refinement/normal_equations.hpp"

namespace consimd::features::detail {

/// By how much errors that neighbours share enlarge the covariance of independent ones; 1 where they share none.
///
/// The pairs are halved across their longest axis three times, into G = 8 groups that lie apart, and six times,
/// into 64. F is the mean square of the groups' scores over that of independent residuals (a block jackknife's), and F
/// - 1 the excess that groups share among their own pairs. The groups' disagreement does not show what the whole scan
/// shares, from its calibration or the motion during the scan. That is taken to be as large as what each group has for
/// itself, G times its part in the mean, and larger still by F_8 / F_64 where errors reach further than from one scale
/// to the next:
///   1 + G (F_8 - 1) max(1, F_8 / F_64)
/// squared: as `squared_residuals` has them; sums: over all pairs.
[[nodiscard]] double shared_error_factor(const ClosestPairs& pairs, const CloudView& target, const PairProblem& problem,
                                         std::span<const float> squared, const NormalEquations& sums);

/// Covariance of (omega, tau) about the centre of the normal equations if residuals are independent, working frame:
/// Huber's sandwich, with the spread of the scores and their slope as observed.
[[nodiscard]] Matrix6d independent_covariance(const NormalEquations& sums);

}  // namespace consimd::features::detail
