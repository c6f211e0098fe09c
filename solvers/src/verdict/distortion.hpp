// Whether what the supporters of a pose miss it by is a distortion of one of the clouds.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail {

/// Whether an affine map, an axis in another unit or a shear, lies between the clouds, which a noise bound is large
/// enough to hide: what hides_another_scale asks of a similarity. Of a motion, without a scale. Caller's frame and
/// unit.
bool hides_a_distortion(const Correspondences& correspondences, const RigidTransform& T_target_source,
                        double noise_bound);

}  // namespace consimd::detail
