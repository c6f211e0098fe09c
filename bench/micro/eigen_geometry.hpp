// What the Eigen baselines have in common: the paper's tests of one correspondence, and Kabsch's fit.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "eigen_baseline.hpp"

namespace consimd::bench::eigen {

inline bool length_consistent(const EigenCloud& c, std::size_t i, std::size_t j, double bound) {
  return std::abs((c.source[i] - c.source[j]).norm() - (c.target[i] - c.target[j]).norm()) < bound;
}

inline double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

inline bool angle_consistent(const EigenCloud& c, std::size_t i, std::size_t j, std::size_t m, double bound) {
  const Eigen::Vector3d x1 = c.source[i] - c.source[m];
  const Eigen::Vector3d x2 = c.source[j] - c.source[m];
  if (x1.norm() <= bound || x2.norm() <= bound) return true;
  const double difference = angle(x1, x2) - angle(c.target[i] - c.target[m], c.target[j] - c.target[m]);
  return std::abs(difference) < std::asin(bound / x1.norm()) + std::asin(bound / x2.norm());
}

inline double residual(const EigenCloud& c, const EigenPose& pose, std::size_t j) {
  return (pose.R * c.source[j] + pose.t - c.target[j]).norm();
}

inline void add(const EigenCloud& c, std::size_t j, double weight, EigenMoments* moments) {
  moments->weight += weight;
  moments->source += weight * c.source[j];
  moments->target += weight * c.target[j];
  moments->cross += weight * c.target[j] * c.source[j].transpose();
}

/// cross: sum w (q - target_mean) (p - source_mean)^T.
inline EigenPose kabsch(const Eigen::Matrix3d& cross, const Eigen::Vector3d& source_mean,
                        const Eigen::Vector3d& target_mean) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d signs(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {R, target_mean - R * source_mean};
}

}  // namespace consimd::bench::eigen
