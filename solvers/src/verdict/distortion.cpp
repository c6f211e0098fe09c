#include "verdict/distortion.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Eigenvalues>

#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

// Without the distortion the bound would be half as large: the variance of the residuals a quarter. Of eight supporters
// with independent errors of one size, 3 n - 6 = 18 degrees of freedom for a rigid motion and 12 for an affine map, one
// pose in two thousand is so, by the beta distribution of 6 and 3; of more, fewer.
constexpr double kHalvesTheBound = 0.25;
constexpr std::size_t kLeastSupporters = 8;
// A distortion that changes lengths by less: residuals of exact data are rounding, which anything may explain.
constexpr double kLeastDistortion = 1e-3;
// A variance of the sources along an axis below this share of the largest is rounding: they are flat. So are those
// whose thickness the map takes away but for this share: noise in depth of a board, which its targets do not have.
constexpr double kFlat = 1e-9;
constexpr double kThicknessLeft = 0.3;
// A thickness that is turned over by so many deviations is that of a mirror image: of a board, whose thickness is
// noise, once in thirty thousand times.
constexpr double kDeviations = 4.0;

// Moved sources and what they miss their targets by, working frame.
struct Residuals {
  Points sources;
  Points errors;
};

Residuals sources_and_errors(const CorrespondenceView& view, const RigidTransform& pose,
                             const std::vector<std::uint32_t>& rows) {
  const auto size = static_cast<Eigen::Index>(rows.size());
  Residuals result{Points(size, 3), Points(size, 3)};
  for (Eigen::Index k = 0; k < size; ++k) {
    const std::uint32_t row = rows[static_cast<std::size_t>(k)];
    const Eigen::Vector3d source(view.source(0)[row], view.source(1)[row], view.source(2)[row]);
    const Eigen::Vector3d target(view.target(0)[row], view.target(1)[row], view.target(2)[row]);
    const Eigen::Vector3d moved = pose.linear() * source;
    result.sources.row(k) = moved.transpose();
    result.errors.row(k) = (target - moved - pose.translation()).transpose();
  }
  return result;
}

// What two kinds of maps leave of the residuals of supporters.
struct AffineShare {
  double rigid = 0.0;           // variance of the residuals about a motion
  double affine = 0.0;          // and about an affine map
  double distortion = 0.0;      // largest share by which that changes a length, if by little
  bool is_turned_over = false;  // along the axis in which the sources are thinnest
};

AffineShare shares(const Residuals& supporters) {
  const auto size = static_cast<double>(supporters.sources.rows());
  const Points x = supporters.sources.rowwise() - supporters.sources.colwise().mean();
  const Points e = supporters.errors.rowwise() - supporters.errors.colwise().mean();
  const Eigen::Matrix3d scatter = x.transpose() * x;
  const Eigen::Matrix3d moments = x.transpose() * e;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(scatter);
  const Eigen::Vector3d& variances = principal.eigenvalues();
  AffineShare result;
  if (!(variances[1] > kFlat * variances[2])) return result;
  // In the principal axes a map of each axis explains the residuals on its own, and a motion by a turn about each.
  const Eigen::Matrix3d& axes = principal.eigenvectors();
  const Eigen::Matrix3d along = axes.transpose() * moments * axes;
  const double thickness_left = 1.0 + along(0, 0) / variances[0];
  const double unexplained = (e * axes.col(0)).squaredNorm() - along(0, 0) * along(0, 0) / variances[0];
  result.is_turned_over =
      thickness_left < -kThicknessLeft &&
      thickness_left * thickness_left * variances[0] * (size - 2.0) > kDeviations * kDeviations * unexplained;
  const bool is_flat = !(variances[0] > kFlat * variances[2]) || thickness_left < kThicknessLeft;
  const int dimensions = is_flat ? 2 : 3;
  Eigen::Matrix3d map = Eigen::Matrix3d::Zero();
  double explained = 0.0;
  for (int axis = 3 - dimensions; axis < 3; ++axis) {
    map.row(axis) = along.row(axis) / variances[axis];
    explained += along.row(axis).squaredNorm() / variances[axis];
  }
  double turned = 0.0;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double score = along(a, b) - along(b, a);
    turned += score * score / (variances[a] + variances[b]);
  }
  const double all = e.squaredNorm();
  result.rigid = (all - turned) / (3.0 * size - 6.0);
  result.affine = (all - explained) / (3.0 * size - 3.0 - 3.0 * dimensions);
  map.leftCols(3 - dimensions).setZero();  // a turn out of the plane
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> stretch(0.5 * (map + map.transpose()), Eigen::EigenvaluesOnly);
  result.distortion = stretch.eigenvalues().cwiseAbs().maxCoeff();
  return result;
}

}  // namespace

bool hides_a_distortion(const Correspondences& correspondences, const RigidTransform& T_target_source,
                        double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const RigidTransform pose = to_working_frame(T_target_source, correspondences);
  const std::vector<std::uint32_t> rows = pose_inliers(view, to_working_pose(pose), noise_bound);
  if (rows.size() < kLeastSupporters) return false;
  const AffineShare share = shares(sources_and_errors(view, pose, rows));
  return share.is_turned_over || (share.distortion > kLeastDistortion && share.affine < kHalvesTheBound * share.rigid);
}

}  // namespace consimd::detail
