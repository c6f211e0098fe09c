// The last stage of the default TCF: inliers re-selected from all correspondences, pose at the statistical limit.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

namespace CONSIMD_EXPORT consimd {

struct PoseRefinementOptions {
  double noise_bound = 0.0;  ///< tau, caller's unit: residuals up to twice as large are looked at
  std::uint32_t max_rounds = 30;
};

struct RefinedPose {
  RigidFit fit;  ///< working frame
  double sigma =
      0.0;  ///< estimated scale of an inlier's residual per axis, its standard deviation if Gaussian; caller's unit
  std::uint32_t exponent = 64;  ///< of the residuals' density: 64 Gaussian, less for heavier tails (see WeightFunction)
  double outlier_density = 0.0;  ///< outliers per unit volume around a predicted target, caller's unit^-3
  double inliers = 0.0;          ///< expected number of inliers
  std::uint32_t rounds = 0;      ///< fits made
  PoseCovariance covariance = PoseCovariance::Zero();  ///< caller's frame and unit; zero if `fit` is not determined
  /// The factor of the sources about their weighted mean with which they would fit best, 1 but for noise where their
  /// scale is known, and its standard deviation. 1 and 0 if `fit` is not determined.
  double scale = 1.0;
  double scale_deviation = 0.0;
  double shared_errors = 1.0;  ///< what errors that supporters share multiply the variances by, 1 or more
  Eigen::Matrix<double, 3, 1, Eigen::DontAlign> centre =
      Eigen::Matrix<double, 3, 1, Eigen::DontAlign>::Zero();  ///< that mean, working frame
};

/// Maximum likelihood for inliers with Gaussian or heavier-tailed residuals among locally uniform outliers. Each round
/// models the histogram of all residuals below twice the noise bound (scale, tails, share and background by expectation
/// maximisation), weights every correspondence with its posterior probability of being an inlier times the weight of
/// its tail, and refits, until the pose stands still. So the noise bound need not be exact, and real residuals, which
/// crowd at small values, get the weight they deserve. `start`: working frame, close enough that most true inliers are
/// within noise_bound. Throws std::invalid_argument on a bad option.
[[nodiscard]] RefinedPose refine_pose(const Correspondences& correspondences, const WorkingPose& start,
                                      const PoseRefinementOptions& options);

}  // namespace consimd
