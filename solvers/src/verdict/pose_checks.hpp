// Whether a consensus determines a rotation at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// A rotation less certain than this, in radians, is not determined by the supporters.
inline constexpr double kLargestRotationDeviation = 0.35;

/// Standard deviation in radians of the rotation about its least certain axis, from the scatter of the sources of the
/// rows within `noise_bound` of the pose. sigma: of their residuals per axis; both in the caller's unit.
double rotation_deviation(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double sigma);

/// Whether a rotation is told by nothing but the noise of points on a line, whose scatter across it looks like
/// information, or by one supporter whose place another row would take: about the line that the others lie on a pose
/// can be turned until a row fits that is as far along the line, and from it, in both clouds. `supporters`: rows within
/// the noise bound, three or more. sigma as above.
bool leaves_a_rotation_free(const CorrespondenceView& view, const std::vector<std::uint32_t>& supporters,
                            double noise_bound, double sigma);

/// Whether all sources coincide or lie on a line, as far as single precision tells.
bool coincident_or_collinear(const Correspondences& correspondences);

/// Rows that agree in length, within twice the noise bound, with each of three, ascending.
std::vector<std::uint32_t> rows_agreeing_with(const Correspondences& correspondences, const IndexTriple& triple,
                                              double noise_bound);

}  // namespace consimd::detail
