#include "verdict/fit_covariance.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>

#include "support/source_scatter.hpp"

namespace consimd::detail {
namespace {

// Nodes of the integrals over the residual: five to a scale or more.
constexpr int kNodes = 64;
// Coordinates in the working frame are rounded to about this.
constexpr double kResolution = 0x1p-24;

Eigen::Matrix3d cross_product_matrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0;
  return matrix;
}

// Variance of a location times the total weight, over the weighted mean square of the residuals per axis. With the
// mixture's density f of residuals, in units of its scale, w f = g ~ y^-(exponent + 1) whatever the outliers, and the
// gradient of f at the residual vector x is -g x. So B = int w r^2 g / 3 = A, and the variance is B / A^2 = 1 / B; the
// weight is int g, the mean square int r^2 g / (3 int g).
double variance_factor(const RobustWeight& weight) {
  if (weight.function != WeightFunction::student_uniform) return 1.0;
  double sum = 0.0;               // of g
  double squares = 0.0;           // of r^2 g
  double weighted_squares = 0.0;  // of w r^2 g
  for (int k = 0; k < kNodes; ++k) {
    const double r = weight.cutoff / weight.scale * (k + 0.5) / kNodes;
    const double y = 1.0 + r * r / (2.0 * weight.exponent);
    double power = y;
    for (std::uint32_t e = weight.exponent; e > 1; e /= 2) power *= power;
    const double g = r * r / (y * power);  // in a shell of radius r
    sum += g;
    squares += r * r * g;
    weighted_squares += r * r * g / (y * (1.0 + weight.odds * power));
  }
  return 9.0 * sum * sum / (squares * weighted_squares);
}

/// The variance of a residual of unit weight, per axis.
double residual_variance(const RigidMoments& moments, const RobustWeight& weight) {
  const double w = moments.weight;
  const double mean_square = std::max(moments.residual / (3.0 * w), kResolution * kResolution);
  return mean_square * variance_factor(weight) * 3.0 * w / std::max(3.0 * w - 8.0, 1.0);
}

}  // namespace

ScaleFit fit_scale(const RigidMoments& moments, const RobustWeight& weight, const RigidTransform& pose, double shared) {
  ScaleFit fit;
  if (!(moments.weight > 0.0)) return fit;
  const Eigen::Vector3d source = Eigen::Map<const Eigen::Vector3d>(moments.source) / moments.weight;
  const Eigen::Vector3d target = Eigen::Map<const Eigen::Vector3d>(moments.target) / moments.weight;
  const Eigen::Matrix3d cross = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(moments.cross) -
                                moments.weight * target * source.transpose();
  const double extent = central_source_scatter(moments).trace();
  fit.centre = source;
  if (!(extent > moments.weight * kResolution * kResolution)) return fit;
  fit.scale = pose.linear().cwiseProduct(cross).sum() / extent;
  fit.deviation = std::sqrt(shared * residual_variance(moments, weight) / extent);
  return fit;
}

PoseCovariance least_squares_covariance(const RigidMoments& moments, double variance, const RigidTransform& pose,
                                        const Correspondences& frame) {
  PoseCovariance covariance = PoseCovariance::Zero();
  const double w = moments.weight;
  if (!(w > 0.0)) return covariance;

  // About the weighted centroid rotation and translation are independent.
  const Eigen::Vector3d centroid = Eigen::Map<const Eigen::Vector3d>(moments.source) / w;
  const Eigen::Matrix3d scatter = central_source_scatter(moments);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(scatter);
  const Eigen::Vector3d information = (scatter.trace() - axes.eigenvalues().array()).max(w * kResolution * kResolution);
  const Eigen::Matrix3d target_axes = pose.linear() * axes.eigenvectors();
  const Eigen::Matrix3d rotation =
      target_axes * (variance / information.array()).matrix().asDiagonal() * target_axes.transpose();

  const Eigen::Vector3d frame_centroid = Eigen::Map<const Eigen::Vector3d>(frame.source_centroid().data());
  const Eigen::Matrix3d lever = cross_product_matrix(pose.linear() * (frame_centroid + centroid / frame.scale()));
  covariance.topLeftCorner<3, 3>() = rotation;
  covariance.bottomLeftCorner<3, 3>() = lever * rotation;
  covariance.bottomRightCorner<3, 3>() = lever * rotation * lever.transpose();
  covariance.bottomRightCorner<3, 3>().diagonal().array() += variance / w / frame.scale() / frame.scale();
  // Symmetric to the last bit.
  return covariance.selfadjointView<Eigen::Lower>();
}

PoseCovariance fit_covariance(const RigidMoments& moments, const RobustWeight& weight, const RigidTransform& pose,
                              const Correspondences& frame, double shared) {
  if (!(moments.weight > 0.0)) return PoseCovariance::Zero();
  return least_squares_covariance(moments, shared * residual_variance(moments, weight), pose, frame);
}

}  // namespace consimd::detail
