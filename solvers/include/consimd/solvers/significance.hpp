// Could chance have given a pose its support?
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd {

/// log10 of the expected number of poses that would be supported as well among correspondences whose sources and
/// targets are paired at random: the number of false alarms of an a-contrario test (Desolneux, Moisan & Morel 2000;
/// Moisan & Stival 2004 for RANSAC). Well below 0: significant. Never above the logarithm of the number of minimal
/// samples; 0 or more when nothing supports the pose.
///
/// Everything is measured on mismatched pairs of the same data, so that the shape of the scene and its clusters count:
/// the chance d that two correspondences are length consistent, the chance c that one is within the bound of `pose`,
/// and the dispersion D of that count (above 1 where correspondences come in clumps, which then count as one). With N
/// correspondences and k supporters,
///   false poses = C(N, 3) d^3 / C(k / D, 3) * P[Binomial((N - 3) / D, c) >= (k - 3) / D]:
/// minimal samples that are pairwise consistent, over the samples that one and the same pose is found from, times the
/// tail. Tested at noise_bound and three smaller bounds, since supporters of a true pose crowd at small residuals; the
/// least is returned, times the number of bounds. pose: working frame. Throws std::invalid_argument on a bad bound.
[[nodiscard]] double log10_false_poses(const Correspondences& correspondences, const WorkingPose& pose,
                                       double noise_bound, std::uint64_t seed);

}  // namespace consimd
