// Errors of poses against their covariances.
#pragma once

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <vector>

namespace consimd::test {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

inline Eigen::Matrix3d cross(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

/// (theta, dt) as `PoseCovariance` defines them.
inline Vector6d pose_error(const RigidTransform& estimate, const RigidTransform& truth) {
  const Eigen::AngleAxisd rotation(truth.linear() * estimate.linear().transpose());
  Vector6d error;
  error << rotation.angle() * rotation.axis(), truth.translation() - estimate.translation();
  return error;
}

/// Squares of the six components that C makes independent and of unit variance, averaged over trials. Their sum, d^T
/// C^-1 d for an error d, is the normalised estimation error squared (NEES), whose mean is 6 if C is right.
struct NormalisedErrors {
  Vector6d squares = Vector6d::Zero();
  std::vector<double> of_trials{};  ///< NEES of each

  void add(const RigidTransform& estimate, const RigidTransform& truth, const PoseCovariance& covariance) {
    const Eigen::LLT<Matrix6d> factors(covariance);
    ASSERT_EQ(factors.info(), Eigen::Success);
    const Vector6d components = factors.matrixL().solve(pose_error(estimate, truth)).cwiseAbs2();
    squares += components;
    of_trials.push_back(components.sum());
  }

  [[nodiscard]] Vector6d mean_squares() const { return squares / static_cast<double>(of_trials.size()); }
  [[nodiscard]] double nees() const { return mean_squares().sum(); }
  [[nodiscard]] double median_nees() const {
    std::vector<double> sorted = of_trials;
    std::ranges::sort(sorted);
    return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
  }
};

}  // namespace consimd::test
