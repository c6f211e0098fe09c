// Could chance have given a pose its support?
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#pragma GCC visibility push(default)

namespace consimd {

/// How closely is looked at a pose that is not beyond doubt at first sight. A glance takes a tenth of the time and may
/// find less significance than there is.
enum class Scrutiny : std::uint8_t { glance, close };

struct Significance {
  /// log10 of the expected number of poses supported as well among correspondences whose sources and targets are paired
  /// at random. Well below 0: significant.
  double log10_false_poses = 0.0;
  /// Share of the supporters that do not repeat another one: sources further apart than the noise bound.
  double independent_share = 1.0;
};

/// The number of false alarms of an a-contrario test (Desolneux, Moisan & Morel 2000; Moisan & Stival 2004 for RANSAC).
/// With N correspondences and k independent supporters,
///   false poses = C(N, 3) d^3 / C(k, 3) * P[Binomial(N - 3, c) >= k - 3]:
/// minimal samples that are pairwise consistent, over those that one and the same pose is found from, times the tail of
/// the further support. The chances are measured on the data, so that the shape of the scene counts: d, that two
/// correspondences are length consistent; c, that the pose takes a source to the target of another correspondence.
/// Clusters of sources that are matched to clusters of targets must not pass for many supporters: those within 1.75
/// bounds of one another count once, and c is at least what the number of near misses, residuals of one to two bounds,
/// lets expect. Tested at noise_bound and down to a third of it, since supporters of a true pose crowd at small
/// residuals; the least is returned, times the number of bounds. Smaller bounds are left out once no doubt is left.
/// pose: working frame. Throws std::invalid_argument on a bad bound.
[[nodiscard]] Significance significance(const Correspondences& correspondences, const WorkingPose& pose,
                                        double noise_bound, std::uint64_t seed, Scrutiny scrutiny = Scrutiny::close);

}  // namespace consimd

#pragma GCC visibility pop
