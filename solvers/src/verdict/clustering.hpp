// Do neighbouring sources have neighbouring targets, whatever the pose?
#pragma once

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// How much more often than correspondences from afar those with neighbouring sources have targets that are neighbours
/// too, as a share of what is possible: about 0 for independent outliers, 1 for clusters of sources that are matched to
/// clusters of targets.
double clustered_share(const CorrespondenceView& view);

}  // namespace consimd::detail
