#include "verdict/kept_coordinates.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include <consimd/kernels/kernel_data.hpp>

#include "verdict/kept_viewpoint.hpp"

namespace consimd::detail {
namespace {

// A viewpoint further away than this sees all sources at one range, as a float has it, and is no further.
constexpr double kFurthest = 1e30;

}  // namespace

SourceCoordinates::SourceCoordinates(const Correspondences& correspondences, std::size_t step) {
  const CorrespondenceView view = correspondences.view();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < view.size(); k += step) {
    const Point p = source_point(view, k);
    const Eigen::Vector3d source(p.x, p.y, p.z);  // the working frame has its origin at the centroid
    scatter += source * source.transpose();
  }
  principal_ = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().transpose();
  viewpoint_ = kept_viewpoint(correspondences);
}

std::array<float, kCoordinates> SourceCoordinates::operator()(const Point& point) const {
  const Eigen::Vector3d source(point.x, point.y, point.z);
  const Eigen::Vector3d along = principal_ * source;
  return {static_cast<float>(along[0]), static_cast<float>(along[1]), static_cast<float>(along[2]),
          static_cast<float>(std::min((source - viewpoint_).norm(), kFurthest)), static_cast<float>(source.norm())};
}

}  // namespace consimd::detail
