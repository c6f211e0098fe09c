// Whether the supporters of a pose tell of another scale, and the pose with a scale of its own.
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "verdict/final_pose.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {

/// x_target = scale * R * x_source + t; the pose is of the scaled source, caller's frame.
struct Similarity {
  double scale = 1.0;
  RigidTransform T_target_source = RigidTransform::Identity();
};

/// Pose and scale in turn, each at its most likely value with the other one. Returns the rounds.
std::uint32_t refine_similarity(const Correspondences& correspondences, double noise_bound, Similarity& similarity);

/// Whether the pose is the part of a similarity that a rigid motion covers: its supporters agree on another scale, and
/// either that explains their residuals, or many more rows support the pose with a scale of its own.
bool is_at_another_scale(const Correspondences& correspondences, const PoseTest& test, const FinalPose& final);

/// Whether a noise bound that was estimated from the rows is as large as it is because they are at another scale.
/// Caller's frame and unit.
bool hides_another_scale(const Correspondences& correspondences, const RigidTransform& T_target_source,
                         double noise_bound);

}  // namespace consimd::detail
