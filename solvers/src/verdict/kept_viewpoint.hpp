// The sensor of clouds that do not have it where they say, from what matches keep of it: the range.
#pragma once

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Where the sensor of the sources was, in the working frame: the viewpoint of the correspondences, or the point about
/// which their rows keep ranges ten times as well, to some point of the targets, and ten times as well as mismatched
/// rows do. Clouds that were moved to their centroids or to a map have it anywhere among or beside the points; one that
/// is several of their lengths away is not found, and ranges about it are positions along a direction. Among fewer than
/// 32 rows, and where there are far ones, none is looked for.
[[nodiscard]] Eigen::Vector3d kept_viewpoint(const Correspondences& correspondences);

}  // namespace consimd::detail
