// The sensor of clouds that do not have it where they say, from what matches keep of it: the range.
#pragma once

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Where the sensor of the sources was, in the working frame: the viewpoint that the correspondences were given, or the
/// point about which their rows keep ranges ten times as well, about whatever point of the targets. Clouds that were
/// moved to their centroids or to a map have it anywhere. Among fewer than 32 rows none is looked for.
[[nodiscard]] Eigen::Vector3d kept_viewpoint(const Correspondences& correspondences);

}  // namespace consimd::detail
