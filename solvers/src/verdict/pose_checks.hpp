// Whether a consensus determines a rotation at all.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// A rotation less certain than this, in radians, is not determined by the supporters.
inline constexpr double kLargestRotationDeviation = 0.35;

/// Standard deviation in radians of the rotation about its least certain axis, from the scatter of the sources of the
/// pose's supporters. sigma: of their residuals per axis, caller's unit.
double rotation_deviation(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double sigma);

/// Whether all sources coincide or lie on a line, as far as single precision tells.
bool coincident_or_collinear(const Correspondences& correspondences);

/// Rows that agree in length, within twice the noise bound, with each of three, ascending.
std::vector<std::uint32_t> rows_agreeing_with(const Correspondences& correspondences, const IndexTriple& triple,
                                              double noise_bound);

/// Whether a reflection aligns more of the set than the pose has supporters. The pairwise lengths that made the set one
/// cannot tell a mirror image, of which a rotation fits whatever lies near a plane.
bool is_mirrored(const Correspondences& correspondences, const std::vector<std::uint32_t>& set, std::size_t supporters,
                 double noise_bound);

}  // namespace consimd::detail
