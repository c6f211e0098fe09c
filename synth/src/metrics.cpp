#include <consimd/synth/metrics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace consimd::synth {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct InlierPoints {
  Eigen::Matrix3Xd source;
  Eigen::Matrix3Xd target;
};

/// Sources multiplied by the scale.
InlierPoints inlier_points(const Problem& problem, double scale) {
  const auto count = static_cast<Eigen::Index>(std::ranges::count(problem.is_inlier, 1));
  InlierPoints points{Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count)};
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 0) continue;
    points.source.col(column) = scale * Eigen::Map<const Eigen::Vector3d>(&problem.source[3 * k]);
    points.target.col(column) = Eigen::Map<const Eigen::Vector3d>(&problem.target[3 * k]);
    ++column;
  }
  return points;
}

}  // namespace

double rotation_error_deg(const RigidTransform& estimate, const RigidTransform& truth) {
  const Eigen::Quaterniond estimated(estimate.linear()), true_one(truth.linear());
  return estimated.angularDistance(true_one) * (180.0 / std::numbers::pi);
}

double translation_error(const RigidTransform& estimate, const RigidTransform& truth) {
  return (estimate.translation() - truth.translation()).norm();
}

double scale_error(double estimate, double truth) { return std::abs(estimate / truth - 1.0); }

double rmse_true_inliers(const Problem& problem, const RigidTransform& estimate, double scale) {
  const InlierPoints points = inlier_points(problem, scale);
  if (points.source.cols() == 0) return kNaN;
  const Eigen::Matrix3Xd residuals =
      ((estimate.linear() * points.source).colwise() + estimate.translation()) - points.target;
  return std::sqrt(residuals.squaredNorm() / static_cast<double>(residuals.cols()));
}

InlierQuality inlier_quality(const Problem& problem, std::span<const std::uint32_t> reported) {
  std::size_t hits = 0;
  for (const std::uint32_t row : reported) {
    if (row >= problem.size()) {
      throw std::out_of_range("reported inlier " + std::to_string(row) + ": expected a row below " +
                              std::to_string(problem.size()));
    }
    hits += problem.is_inlier[row];
  }
  const auto inliers = static_cast<std::size_t>(std::ranges::count(problem.is_inlier, 1));
  const auto share = [hits](std::size_t of) {
    return of == 0 ? kNaN : static_cast<double>(hits) / static_cast<double>(of);
  };
  return {share(reported.size()), share(inliers)};
}

RigidTransform oracle(const Problem& problem) {
  RigidTransform pose;
  const InlierPoints points = inlier_points(problem, problem.scale);
  if (points.source.cols() == 0) {
    pose.matrix().setConstant(kNaN);
  } else {
    pose.matrix() = Eigen::umeyama(points.source, points.target, /*with_scaling=*/false);
  }
  return pose;
}

}  // namespace consimd::synth
