// Rings about a sensor: the motions that differ from a pose by a turn about it.
#pragma once

#include <consimd/kernels/correspondences.hpp>

#include "support/best_poses.hpp"
#include "verdict/shifted_motion.hpp"

namespace consimd::detail {

/// Poses that the best one leads to when the sources are turned about the axis of their least spread through their
/// viewpoint, by angles all around: where matches keep range and height, a turn has some support whatever it is. Each
/// is brought into place, and one that shares most supporters with the best pose or is met twice does not count.
/// noise_bound: caller's unit. None where a row is far (Correspondences::far_rows) or the viewpoint is too far to turn
/// about.
RepeatedMotions turned_motions(const Correspondences& correspondences, const BestPoses& poses, double noise_bound);

}  // namespace consimd::detail
