// Repeated structure: the motion that differs from a pose by a shift alone.
#pragma once

#include <consimd/kernels/correspondences.hpp>

#include "support/best_poses.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {

/// The pose with the rotation of the best one that most rows agree on which that misses by more than kNearMisses
/// bounds, brought into place: matches of a window with any other support many shifts of a facade alike. A pose without
/// support where no three rows agree. noise_bound: caller's unit.
PoseCandidate shifted_motion(const Correspondences& correspondences, const BestPoses& poses, double noise_bound);

}  // namespace consimd::detail
