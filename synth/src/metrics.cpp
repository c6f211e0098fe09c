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

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::synth {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// work(source, target) of each true inlier in input order, sources multiplied by the scale. Returns their number.
template <typename Work>
double for_each_inlier(const Problem& problem, double scale, const Work& work) {
  double count = 0.0;
  for (std::size_t k = 0; k < problem.size(); ++k) {
    if (problem.is_inlier[k] == 0) continue;
    const Eigen::Map<const Eigen::Vector3d> source(&problem.source[3 * k]), target(&problem.target[3 * k]);
    work(Eigen::Vector3d(scale * source), target);
    ++count;
  }
  return count;
}

}  // namespace

double rotation_error_deg(const RigidTransform& estimate, const RigidTransform& truth) {
  const Eigen::Quaterniond estimated(estimate.linear()), true_one(truth.linear());
  const Eigen::Quaterniond between = estimated * true_one.conjugate();
  return 2.0 * elementary::atan2(between.vec().norm(), std::abs(between.w())) * (180.0 / std::numbers::pi);
}

double translation_error(const RigidTransform& estimate, const RigidTransform& truth) {
  return (estimate.translation() - truth.translation()).norm();
}

double scale_error(double estimate, double truth) { return std::abs(estimate / truth - 1.0); }

double rmse_true_inliers(const Problem& problem, const RigidTransform& estimate, double scale) {
  double squares = 0.0;
  const double count = for_each_inlier(problem, scale, [&](const Eigen::Vector3d& source, const auto& target) {
    squares += (estimate * source - target).squaredNorm();
  });
  return count > 0.0 ? std::sqrt(squares / count) : kNaN;
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
  // Sums in input order: Eigen's products of long matrices add in blocks that fit the processor's caches.
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero(), target_mean = Eigen::Vector3d::Zero();
  const double count = for_each_inlier(problem, problem.scale, [&](const Eigen::Vector3d& source, const auto& target) {
    source_mean += source;
    target_mean += target;
  });
  RigidTransform pose;
  if (count == 0.0) {
    pose.matrix().setConstant(kNaN);
    return pose;
  }
  source_mean /= count;
  target_mean /= count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for_each_inlier(problem, problem.scale, [&](const Eigen::Vector3d& source, const auto& target) {
    covariance += (target - target_mean) * (source - source_mean).transpose();
  });
  // Kabsch's fit.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool mirrored = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0;
  const Eigen::Vector3d signs(1.0, 1.0, mirrored ? -1.0 : 1.0);
  pose.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  pose.translation() = target_mean - pose.linear() * source_mean;
  return pose;
}

}  // namespace consimd::synth
