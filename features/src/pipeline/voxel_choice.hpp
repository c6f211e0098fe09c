// Voxels for clouds whose spacing nobody has told.
#pragma once

#include <consimd/kernels/cloud.hpp>

namespace consimd::features::detail {

/// The side, to two digits, of voxels of which the points of a cloud occupy about `wanted`; 1 where all points lie in
/// one place. Not of an empty cloud.
double voxel_for(const Cloud& cloud, double wanted);

/// Voxels that hold so many points each, or more where `choose_voxel` lets them: a scanner's points lie close to one
/// another along its rings alone, and voxels of that side show rings where larger ones show surfaces.
double voxel_across_rings(const Cloud& cloud, double points_a_voxel);

}  // namespace consimd::features::detail
