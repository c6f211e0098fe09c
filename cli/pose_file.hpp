// A rigid pose in a text file.
#pragma once

#include <filesystem>

#include <consimd/poses/rigid_fit.hpp>

namespace consimd::cli {

/// Reads a 4 x 4 or 3 x 4 matrix [R t]. R must be a rotation within 1e-3 an entry of R R^T, as files with few digits
/// are; the nearest rotation is returned. Throws std::runtime_error that names the file.
[[nodiscard]] RigidTransform read_pose(const std::filesystem::path& path);

}  // namespace consimd::cli
