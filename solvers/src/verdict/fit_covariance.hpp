// The covariance of a robust fit.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

namespace consimd::detail {

/// Covariance, in the caller's frame and unit, of the fit to `moments` = robust_moments(., ., weight) of
/// correspondences in the working frame of `frame`. `pose`: that fit, working frame. Zero if the moments have no
/// weight. `shared`: by what errors that supporters share multiply it (see shared_errors.hpp).
///
/// The sandwich A^-1 B A^-1 of an M-estimator (Huber 1967), for isotropic residuals that do not depend on the position:
/// both A and B are multiples of the weighted normal matrix. The observed mean square of the residuals scales B; what
/// the weights do to A and B, where inliers and outliers cannot be told apart or tails are heavy, is taken from the
/// mixture that student_uniform weights are the posterior of (its cutoff at most a dozen scales). Other weights count
/// as plain least squares. With a total weight of w, 3 w residuals share six fitted parameters: the result is the
/// covariance of the Student distribution that the pose then has, 3 w / (3 w - 8) times the maximum-likelihood one.
PoseCovariance fit_covariance(const RigidMoments& moments, const RobustWeight& weight, const RigidTransform& pose,
                              const Correspondences& frame, double shared);

/// The covariance of a fit whose residuals of unit weight have this variance per axis, working frame. `moments`:
/// weight, source and source_scatter are read.
PoseCovariance least_squares_covariance(const RigidMoments& moments, double variance, const RigidTransform& pose,
                                        const Correspondences& frame);

/// The scale of the sources about `centre`, their weighted mean, that fits the same moments best in the least-squares
/// sense, and its standard deviation as above. About that mean it is independent of rotation and translation. Working
/// frame. 1 and 0 if the moments have no weight or no extent.
struct ScaleFit {
  double scale = 1.0;
  double deviation = 0.0;
  Eigen::Matrix<double, 3, 1, Eigen::DontAlign> centre = Eigen::Matrix<double, 3, 1, Eigen::DontAlign>::Zero();
};
ScaleFit fit_scale(const RigidMoments& moments, const RobustWeight& weight, const RigidTransform& pose, double shared);

}  // namespace consimd::detail
