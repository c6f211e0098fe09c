// From many poses to the best one: scored on all correspondences, the promising ones refined.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/solvers/pose_ranking.hpp>

#include "support/best_poses.hpp"

namespace consimd::detail {

/// Ranks the hypotheses by their support among all correspondences (ties: the first), refits the best ones, and those
/// that are other motions, to their supporters, and offers these to `poses`, whose score decides then. Returns the
/// position of the one that the best pose came from; none when no hypothesis is better than the best pose before.
/// The support that ranks counts residuals below `ranking_tolerance` noise bounds.
std::optional<std::size_t> select_pose(const Correspondences& correspondences, std::span<const WorkingPose> hypotheses,
                                       double noise_bound, PoseRanking ranking, BestPoses& poses,
                                       double ranking_tolerance = 1.0);

}  // namespace consimd::detail
