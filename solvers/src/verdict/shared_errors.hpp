// Errors that supporters of a pose share: neighbours on a distorted scan, many matches of one patch.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::detail {

/// How many times larger the covariance of the fit to `moments` = robust_moments(view, ., weight) is than residuals
/// that are independent of one another give, >= 1. `pose`: that fit, working frame. 1 for weights that are not
/// student_uniform.
///
/// Parts of the scene vote on the pose. Planes through the supporters' centroid across their three principal axes make
/// halves and quarters. The difference of the poses of two halves, whitened by the covariance that independent
/// residuals give it, has six components of mean square 1; shared errors make it larger. (It is an analysis of variance
/// between groups, as in a block jackknife: Künsch 1989.) So does the difference of two quarters of a half, but less if
/// the errors reach further than a quarter; from the halves to the whole the mean square is taken to grow by the same
/// ratio once more. Halves that differ no more than independent residuals make them once in fifty times give 1.
double shared_error_factor(const CorrespondenceView& view, const RobustWeight& weight, const RigidMoments& moments,
                           const RigidTransform& pose);

}  // namespace consimd::detail
