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

/// How many of the set a reflection aligns. The pairwise lengths that made the set one cannot tell a mirror image, of
/// which a rotation fits whatever lies near a plane.
std::size_t mirrored_supporters(const Correspondences& correspondences, const std::vector<std::uint32_t>& set,
                                double noise_bound);

/// Whether so many are clearly more than the pose has supporters.
[[nodiscard]] bool is_mirrored(std::size_t mirrored_supporters, std::size_t supporters);

/// Whether so many of the set, found among so many rows, are a mirror image and no coincidence.
[[nodiscard]] bool is_mirror_image(std::size_t mirrored_supporters, std::size_t set_size, std::size_t rows);

}  // namespace consimd::detail
