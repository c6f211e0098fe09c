#include "pose_file.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "number_table.hpp"

namespace consimd::cli {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(fmt::format("{}: {}", path.string(), what));
}

Eigen::Matrix<double, 3, 4> read_matrix(const std::filesystem::path& path) {
  const NumberTable table = read_number_table(path, 4);
  if (table.rows() != 3 && table.rows() != 4) fail(path, fmt::format("expected 3 or 4 rows, got {}", table.rows()));
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> pose(table.values.data());
  if (table.rows() == 4 &&
      Eigen::Map<const Eigen::RowVector4d>(table.values.data() + 12) != Eigen::RowVector4d(0, 0, 0, 1)) {
    fail(path, "the last row must be 0 0 0 1");
  }
  return pose;
}

RigidTransform nearest_pose(const std::filesystem::path& path, const Eigen::Matrix3d& rotation,
                            const Eigen::Vector3d& translation) {
  constexpr double kTolerance = 1e-3;
  const double deviation = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kTolerance)) {
    fail(path, fmt::format("not a rotation: R R^T is {:.3g} off the identity", deviation));
  }
  if (rotation.determinant() < 0.0) fail(path, "not a rotation but a reflection: its determinant is negative");

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  RigidTransform result = RigidTransform::Identity();
  result.linear() = svd.matrixU() * svd.matrixV().transpose();
  result.translation() = translation;
  return result;
}

}  // namespace

RigidTransform read_pose(const std::filesystem::path& path) {
  const Eigen::Matrix<double, 3, 4> matrix = read_matrix(path);
  return nearest_pose(path, matrix.leftCols<3>(), matrix.col(3));
}

ScaledPose read_scaled_pose(const std::filesystem::path& path) {
  const Eigen::Matrix<double, 3, 4> matrix = read_matrix(path);
  const double scale = std::cbrt(matrix.leftCols<3>().determinant());
  if (scale < 0.0) fail(path, "not a rotation but a reflection: its determinant is negative");
  if (!(scale > 0.0) || !std::isfinite(scale)) fail(path, fmt::format("its scale is {}, expected one above 0", scale));
  return {nearest_pose(path, matrix.leftCols<3>() / scale, matrix.col(3)), scale};
}

}  // namespace consimd::cli
