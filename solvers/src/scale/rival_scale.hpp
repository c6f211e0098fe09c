// Whether rows whose evidence for a pose is thin tell of another scale.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd::detail {

/// Takes a pose of little evidence away where the scale that pair lengths vote for gives one with more support than its
/// rival may have: a few neighbours among rows at another scale fit a rigid motion. No look at other poses.
void refuse_at_rival_scale(const Correspondences& correspondences, Registration& result);

}  // namespace consimd::detail
