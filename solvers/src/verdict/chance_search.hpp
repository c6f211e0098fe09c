// Is the best pose of a search more than chance? Where the closed form leaves doubt, the search is repeated on random
// pairings of the same points.
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/significance.hpp>

#include "support/pose_candidate.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {

/// log10 of the number of false poses below which a support is significant.
inline constexpr double kSignificant = -3.0;
/// From here on the closed form is believed (`significance`); up to kLog10PairingsUseless pairings may still tell
/// otherwise.
inline constexpr double kLog10ClosedFormBelieved = -4.5;
inline constexpr double kLog10PairingsUseless = 3.0;

/// log10 of the expected number of false poses with the support of `best`, which was found from `seeds` seeds;
/// `closed_form`: what `significance` says of it. Random pairings tell more exactly than that what chance can do,
/// unless the correspondences are so clustered that random pairings are no match for them.
double log10_false_poses(const Correspondences& correspondences, const PoseTest& test, const PoseCandidate& best,
                         std::uint32_t seeds, const Significance& closed_form);

/// log10 of the expected number of poses of at least this score, found from `seeds` seeds, among correspondences like
/// these whose sources and targets are paired at random. Estimated from a few pairings, searched from a few seeds each,
/// and the exponential tail that the greatest of many scores has beyond their mean (Gumbel).
double log10_chance_of_score(const Correspondences& correspondences, const PoseTest& test, double score,
                             std::uint32_t seeds);

}  // namespace consimd::detail
