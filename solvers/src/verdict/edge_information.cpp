#include <consimd/solvers/edge_information.hpp>

#include <Eigen/Cholesky>

#include <stdexcept>

namespace consimd {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// A pivot below this share of its diagonal element has lost all but a few digits.
constexpr double kFewDigits = 1e-12;

[[noreturn]] void reject(const PoseCovariance& covariance) {
  throw std::invalid_argument(covariance.isZero(0.0)
                                  ? "covariance is zero, expected that of a registration that has a pose"
                                  : "covariance is not positive definite; take sources nearer to their origin");
}

Matrix6d inverse(const Matrix6d& covariance) {
  // Rotations and lengths have different units: brought to unit variances first.
  const Eigen::Matrix<double, 6, 1> variances = covariance.diagonal();
  if (!(variances.array() > 0.0).all() || !variances.allFinite()) reject(covariance);
  const auto units = variances.cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::LLT<Matrix6d> factors(units * covariance * units);
  if (factors.info() != Eigen::Success) reject(covariance);
  if (!(factors.matrixLLT().diagonal().array().square() > kFewDigits).all()) reject(covariance);
  const Matrix6d half = factors.matrixL().solve(Matrix6d(units));
  const Matrix6d result = half.transpose() * half;
  return result.selfadjointView<Eigen::Lower>();
}

}  // namespace

EdgeInformation edge_information(const RigidTransform& T_target_source, const PoseCovariance& covariance,
                                 PoseGraphLibrary library) {
  // D = Z^-1 Z_true has the rotation R^-1 Exp(theta) R = Exp(R^-1 theta) and the translation R^-1 dt.
  const Eigen::Matrix3d to_source = T_target_source.linear().transpose();
  Matrix6d error = Matrix6d::Zero();  // of the library over (theta, dt)
  if (library == PoseGraphLibrary::g2o) {
    error.topRightCorner<3, 3>() = to_source;
    error.bottomLeftCorner<3, 3>() = 0.5 * to_source;
  } else {
    error.topLeftCorner<3, 3>() = to_source;
    error.bottomRightCorner<3, 3>() = to_source;
  }
  return inverse(error * covariance * error.transpose());
}

}  // namespace consimd
