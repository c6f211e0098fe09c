// A rigid pose in a text file.
#pragma once

#include <filesystem>

#include <consimd/poses/rigid_fit.hpp>

namespace consimd::cli {

/// x_target = R (scale * x_source) + t.
struct ScaledPose {
  RigidTransform T_target_source = RigidTransform::Identity();
  double scale = 1.0;
};

/// Reads a 4 x 4 or 3 x 4 matrix [s R t], R a rotation as below, s > 0. Throws std::runtime_error that names the file.
[[nodiscard]] ScaledPose read_scaled_pose(const std::filesystem::path& path);

/// Reads a 4 x 4 or 3 x 4 matrix [R t]. R must be a rotation within 1e-3 an entry of R R^T, as files with few digits
/// are; the nearest rotation is returned. Throws std::runtime_error that names the file.
[[nodiscard]] RigidTransform read_pose(const std::filesystem::path& path);

}  // namespace consimd::cli
