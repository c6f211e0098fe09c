// A pose with its support, and who supports it.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail {

/// A pose and its support among all correspondences.
struct PoseCandidate {
  WorkingPose pose{};
  PoseSupport support{};
};

/// The pose with its support within `noise_bound`.
PoseCandidate scored(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound);
/// The same for a pose of the caller's frame.
PoseCandidate scored(const Correspondences& correspondences, const RigidTransform& T_target_source, double noise_bound);

/// Refits `start` to the correspondences within a bound that shrinks to `noise_bound`, and returns the pose of best
/// score met on the way.
PoseCandidate locally_optimise(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound);

/// The same, and from there again with bounds from three times `noise_bound` on: for a pose that may hang on a part of
/// its supporters.
PoseCandidate widely_optimise(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound);

/// Rows within `noise_bound` of `pose`, ascending.
std::vector<std::uint32_t> pose_inliers(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound);

}  // namespace consimd::detail
