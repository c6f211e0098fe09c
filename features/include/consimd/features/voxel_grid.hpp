// A cloud thinned out to one point a voxel.
#pragma once

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// The mean of the points in each occupied cube of side `voxel` (caller's unit), by cube: x ascending fastest, then y,
/// then z, counted from the cloud's lowest corner. In the frame of `cloud`; without normals. The same for any number of
/// threads. Memory: 40 bytes a voxel, up to as many times as the cloud has blocks of 131 072 points.
/// Throws std::invalid_argument unless `voxel` is finite and > 0, or where the cloud is more than 2^20 voxels long.
[[nodiscard]] Cloud voxel_grid(const Cloud& cloud, double voxel);

/// How many voxels of that side are occupied. Throws as above.
[[nodiscard]] std::size_t occupied_voxels(const Cloud& cloud, double voxel);

}  // namespace features
}  // namespace consimd
