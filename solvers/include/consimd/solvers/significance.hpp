// Could chance have given a pose its support?
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// How closely is looked at a pose.
enum class Scrutiny : std::uint8_t {
  plain,   ///< held against random pairing alone, which compares poses and bounds: finds at least as
           ///< much significance as there is
  glance,  ///< a tenth of the time of a close look; may find less significance than there is
  close,   ///< all of it
};

struct Significance {
  /// log10 of the expected number of poses supported as well if sources and targets were paired at random, but for what
  /// matchers keep. Well below 0: significant.
  double log10_false_poses = 0.0;
};

/// The number of false alarms of an a-contrario test (Desolneux, Moisan & Morel 2000; Moisan & Stival 2004 for RANSAC).
/// With N correspondences, s supporters, k of them independent,
///   false poses = C(N, 3) d^3 / C(s, 3) * P[Binomial(N - 3, c) >= k - 3]:
/// minimal samples that are pairwise consistent, over those that one and the same pose is found from, times the tail of
/// the further support. The chances are measured on the data: d, that two correspondences are length consistent; c,
/// that the pose takes a source to the target of another correspondence. They are those of random pairing, or of
/// pairing within strata of correspondences whose sources are alike in range, height, position along an axis or place,
/// whichever makes the pose least significant: matchers keep such things, and a pose that fits what they keep must not
/// look like more. Independent supporters have sources further apart than outliers are seen to move as one.
/// Tested at noise_bound and down to a third of it, since supporters of a true pose crowd at small residuals; the least
/// is returned, times the number of bounds. A pose has one value: nothing is drawn anew.
/// pose: working frame. Throws std::invalid_argument on a bad bound.
[[nodiscard]] Significance significance(const Correspondences& correspondences, const WorkingPose& pose,
                                        double noise_bound, Scrutiny scrutiny = Scrutiny::close);

}  // namespace consimd
