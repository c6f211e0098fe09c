#include "pose_file.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "number_table.hpp"

namespace consimd::cli {

RigidTransform read_pose(const std::filesystem::path& path) {
  const auto fail = [&path](const std::string& what) -> void {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), what));
  };
  const NumberTable table = read_number_table(path, 4);
  if (table.rows() != 3 && table.rows() != 4) fail(fmt::format("expected 3 or 4 rows, got {}", table.rows()));
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> pose(table.values.data());
  if (table.rows() == 4 &&
      Eigen::Map<const Eigen::RowVector4d>(table.values.data() + 12) != Eigen::RowVector4d(0, 0, 0, 1)) {
    fail("the last row must be 0 0 0 1");
  }

  constexpr double kTolerance = 1e-3;
  const Eigen::Matrix3d rotation = pose.leftCols<3>();
  const double deviation = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(deviation <= kTolerance)) fail(fmt::format("not a rotation: R R^T is {:.3g} off the identity", deviation));
  if (rotation.determinant() < 0.0) fail("not a rotation but a reflection: its determinant is negative");

  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  RigidTransform result = RigidTransform::Identity();
  result.linear() = svd.matrixU() * svd.matrixV().transpose();
  result.translation() = pose.col(3);
  return result;
}

}  // namespace consimd::cli
