// Whether what the supporters of a pose miss it by is a distortion of one of the clouds.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail {

/// Whether a noise bound that was estimated from the rows is as large as it is because an affine map, an axis in
/// another unit, lies between the clouds: what hides_another_scale asks of a similarity. Caller's frame and unit.
bool hides_a_distortion(const Correspondences& correspondences, const RigidTransform& T_target_source,
                        double noise_bound);

}  // namespace consimd::detail
