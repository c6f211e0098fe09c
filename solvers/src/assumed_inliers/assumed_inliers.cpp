#include <consimd/solvers/assumed_inliers.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <consimd/poses/rigid_fit.hpp>

#include "call/option_checks.hpp"
#include "call/solver_call.hpp"
#include "verdict/fit_covariance.hpp"
#include "verdict/mirror_image.hpp"
#include "verdict/pose_checks.hpp"

namespace consimd {
namespace {

// Coordinates in the working frame are rounded to about this.
constexpr double kResolution = 1e-7;
// A scale or a reflection that leaves less than this share of the squared residuals, or a row without which less is
// left, is what the residuals are about. A pose that leaves more of the squared extent does not fit.
constexpr double kLeft = 0.01;
// A pose that leaves more of it tells nothing, however well many rows determine it: rows at random leave all and more.
constexpr double kMeaningless = 0.5;
// The noise of four rows looks like an odd one in 6 of 1000 (4000 draws), that of five or more never did.
constexpr std::size_t kLeastWithOddRow = 5;
// A row that makes up most of the residuals has one of the largest, however far it pulls the pose.
constexpr std::size_t kSuspects = 16;
constexpr std::size_t kNoRow = std::numeric_limits<std::size_t>::max();

Eigen::Vector3d source_vector(const CorrespondenceView& view, std::size_t k) {
  return {view.source(0)[k], view.source(1)[k], view.source(2)[k]};
}

Eigen::Vector3d target_vector(const CorrespondenceView& view, std::size_t k) {
  return {view.target(0)[k], view.target(1)[k], view.target(2)[k]};
}

// Sums of one cloud.
struct Cloud {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();

  void add(const Eigen::Vector3d& point) {
    sum += point;
    scatter += point * point.transpose();
  }

  // Sum of the squared distances from the centroid.
  [[nodiscard]] double extent(double count) const { return scatter.trace() - sum.squaredNorm() / count; }

  // What the points determine. `sigma`: deviation of a residual per axis, working frame.
  [[nodiscard]] PointGeometry geometry(double count, double sigma) const {
    const Eigen::Vector3d axes =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter - sum * sum.transpose() / count).eigenvalues();
    const auto free = [&](double information) {
      return std::max(sigma, kResolution) > detail::kLargestRotationDeviation * std::sqrt(std::max(information, 0.0));
    };
    if (free(axes[2])) return PointGeometry::coincident;
    return free(axes[0] + axes[1]) ? PointGeometry::collinear : PointGeometry::determined;
  }
};

// Moments in double: with few rows single-precision sums would be the larger part of the error.
struct Sums {
  Cloud source;
  Cloud target;
  RigidMoments moments{};

  // What the points determine where a fit leaves squared distances and a deviation.
  [[nodiscard]] PointGeometry geometry(double squares, double sigma) const {
    const double count = moments.weight;
    const PointGeometry exact = std::max(source.geometry(count, 0.0), target.geometry(count, 0.0));
    if (exact != PointGeometry::determined) return exact;
    const double extent = std::min(source.extent(count), target.extent(count));
    if (squares > kMeaningless * extent) return PointGeometry::contradictory;
    const PointGeometry found = std::max(source.geometry(count, sigma), target.geometry(count, sigma));
    const bool fits = squares < kLeft * extent;
    return found == PointGeometry::determined || fits ? found : PointGeometry::contradictory;
  }

  // What a fit and the scales 1 and the best one leave of the squared distances of the rows.
  struct Left {
    double squares;
    double squares_scaled;
    double scale;
  };
  [[nodiscard]] Left left_by(const RigidMoments& fitted, const RigidFit& fit) const {
    const double count = fitted.weight;
    const Eigen::Vector3d source_sum = Eigen::Map<const Eigen::Vector3d>(fitted.source);
    const Eigen::Matrix3d cross = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(fitted.cross) -
                                  target.sum * source_sum.transpose() / count;
    const double of_source = source.extent(count);
    const double of_target = target.extent(count);
    const double aligned = fit.pose.linear().cwiseProduct(cross).sum();
    return {of_source + of_target - 2.0 * aligned, of_target - aligned * aligned / of_source, aligned / of_source};
  }
};

Sums sums_of(const CorrespondenceView& view, std::size_t without = kNoRow) {
  Sums sums;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < view.size(); ++k) {
    if (k == without) continue;
    const Eigen::Vector3d p = source_vector(view, k);
    const Eigen::Vector3d q = target_vector(view, k);
    sums.source.add(p);
    sums.target.add(q);
    cross += q * p.transpose();
  }
  RigidMoments& moments = sums.moments;
  moments.weight = static_cast<double>(view.size() - (without == kNoRow ? 0 : 1));
  Eigen::Map<Eigen::Vector3d>(moments.source) = sums.source.sum;
  Eigen::Map<Eigen::Vector3d>(moments.target) = sums.target.sum;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(moments.cross) = cross;
  const Eigen::Matrix3d& s = sums.source.scatter;
  const double upper[] = {s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)};
  std::ranges::copy(upper, std::begin(moments.source_scatter));
  return sums;
}

// See AssumedInliers::odd_row. Asked where the residuals are more than rounding.
std::optional<std::uint32_t> odd_row(const CorrespondenceView& view, const std::vector<double>& residuals,
                                     double squares) {
  if (view.size() < kLeastWithOddRow) return std::nullopt;
  std::vector<std::uint32_t> suspects(view.size());
  std::iota(suspects.begin(), suspects.end(), 0U);
  const auto end = suspects.begin() + static_cast<std::ptrdiff_t>(std::min(suspects.size(), kSuspects));
  std::partial_sort(suspects.begin(), end, suspects.end(), [&](std::uint32_t a, std::uint32_t b) {
    return residuals[a] != residuals[b] ? residuals[a] > residuals[b] : a < b;
  });
  suspects.erase(end, suspects.end());
  const auto left_without = [&](std::uint32_t row) {
    const Sums others = sums_of(view, row);
    return others.left_by(others.moments, rigid_fit(others.moments)).squares;
  };
  const std::uint32_t row = *std::ranges::min_element(suspects, {}, left_without);
  return left_without(row) < kLeft * squares ? std::optional(row) : std::nullopt;
}

void solve(const Correspondences& correspondences, AssumedInliers& result) {
  const CorrespondenceView view = correspondences.view();
  Registration& registration = result.registration;
  if (view.size() < 3) {
    registration.status = Status::too_few_correspondences;
    return;
  }
  Sums sums = sums_of(view);
  const RigidFit fit = rigid_fit(sums.moments);
  std::vector<double> residuals(view.size());
  for (std::size_t k = 0; k < view.size(); ++k) {
    residuals[k] = (fit.pose * source_vector(view, k) - target_vector(view, k)).norm();
  }
  const double squares = std::inner_product(residuals.begin(), residuals.end(), residuals.begin(), 0.0);
  const double count = sums.moments.weight;
  const double sigma = std::sqrt(squares / (3.0 * count - 6.0));
  const double resolved = 3.0 * count * kResolution * kResolution;
  const Sums::Left left = sums.left_by(sums.moments, fit);
  // Rounding leaves as much of rows that fit.
  const bool tell = squares * kLeft > resolved;
  if (tell && left.scale > 0.0 && left.squares_scaled < kLeft * squares) result.other_scale = left.scale;
  const RigidMoments image = detail::mirrored(sums.moments);
  // Three points are their own mirror image.
  registration.mirrored = tell && count > 3.0 && sums.left_by(image, rigid_fit(image)).squares < kLeft * squares;
  if (tell) result.odd_row = odd_row(view, residuals, squares);
  result.geometry = sums.geometry(squares, sigma);
  if (result.geometry == PointGeometry::determined && !fit.determined()) result.geometry = PointGeometry::collinear;
  if (result.geometry != PointGeometry::determined) {
    registration.status = Status::degenerate_geometry;
    return;
  }
  for (double& residual : residuals) residual /= view.scale();
  result.residuals = std::move(residuals);
  result.sigma = sigma / view.scale();
  registration.status = Status::success;
  registration.T_target_source = to_caller_frame(fit.pose, correspondences);
  registration.inliers.resize(view.size());
  std::iota(registration.inliers.begin(), registration.inliers.end(), 0U);
  registration.noise_bound = std::ranges::max(result.residuals);
  registration.noise_bound_asked = registration.noise_bound;
  registration.consistency_bound = 2.0 * registration.noise_bound;
  registration.covariance = detail::least_squares_covariance(sums.moments, sigma * sigma, fit.pose, correspondences);
}

}  // namespace

std::string_view to_string(PointGeometry geometry) noexcept {
  switch (geometry) {
    case PointGeometry::determined:
      return "determined";
    case PointGeometry::contradictory:
      return "contradictory";
    case PointGeometry::collinear:
      return "collinear";
    case PointGeometry::coincident:
      return "coincident";
  }
  return "unknown";
}

AssumedInliers register_assumed_inliers(const Correspondences& correspondences) {
  if (!correspondences.far_rows().empty()) {
    throw std::invalid_argument("row " + std::to_string(correspondences.far_rows().front()) +
                                " lies hundreds of times the extent of the others away, expected all rows to be right: "
                                "remove it");
  }
  detail::require_usable_unit(correspondences);
  AssumedInliers result;
  result.registration = detail::start_registration(0.0, 0.0, 0);
  StageReport stage{"least_squares", correspondences.size()};
  {
    const detail::StageClock clock(result.registration.seconds);
    solve(correspondences, result);
  }
  stage.output = result.registration.inliers.size();
  stage.iterations = 1;
  stage.seconds = result.registration.seconds;
  result.registration.stages = {stage};
  return result;
}

}  // namespace consimd
