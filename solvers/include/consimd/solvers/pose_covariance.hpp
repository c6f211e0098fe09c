// How far the true pose may be from an estimated one.
#pragma once

#include <Eigen/Core>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Covariance of the error (theta, dt) of a pose, in this order:
///   R_true = Exp(theta) R_estimate, theta in rad;  t_true = t_estimate + dt, caller's unit;
/// both along the axes of the target frame. Symmetric, positive semi-definite up to rounding; never NaN where a double
/// holds the squares of the coordinates.
///
/// dt is the error at the origin of the source frame; lever arms make it large, and tied to theta, where the data are
/// far from there. The error of the image of a source point p is dt - [R p]x theta, so its covariance is J C J^T with
/// J = [-[R p]x, I]. That is first order in theta: it holds where |theta|^2 |R p| / 2 is small beside the position's
/// deviation, so with map coordinates ask for points near the data, not for dt itself.
///
/// Unaligned storage, as that of RigidTransform.
using PoseCovariance = Eigen::Matrix<double, 6, 6, Eigen::DontAlign>;
static_assert(sizeof(PoseCovariance) == 36 * sizeof(double) && alignof(PoseCovariance) == alignof(double));

}  // namespace consimd
