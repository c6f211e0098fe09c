#include "eigen_baseline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace consimd::bench::eigen {
namespace {

bool length_consistent(const EigenCloud& c, std::size_t i, std::size_t j, double bound) {
  return std::abs((c.source[i] - c.source[j]).norm() - (c.target[i] - c.target[j]).norm()) < bound;
}

double angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0));
}

bool angle_consistent(const EigenCloud& c, std::size_t i, std::size_t j, std::size_t m, double bound) {
  const Eigen::Vector3d x1 = c.source[i] - c.source[m];
  const Eigen::Vector3d x2 = c.source[j] - c.source[m];
  if (x1.norm() <= bound || x2.norm() <= bound) return true;
  const double difference = angle(x1, x2) - angle(c.target[i] - c.target[m], c.target[j] - c.target[m]);
  return std::abs(difference) < std::asin(bound / x1.norm()) + std::asin(bound / x2.norm());
}

double residual(const EigenCloud& c, const EigenPose& pose, std::size_t j) {
  return (pose.R * c.source[j] + pose.t - c.target[j]).norm();
}

template <typename Test>
std::uint32_t count(const EigenCloud& c, const Test& test) {
  std::uint32_t passes = 0;
  for (std::size_t j = 0; j < c.source.size(); ++j) {
    if (test(j)) ++passes;
  }
  return passes;
}

template <typename Test>
void collect(const EigenCloud& c, const Test& test, std::vector<std::uint32_t>* set) {
  set->clear();
  for (std::size_t j = 0; j < c.source.size(); ++j) {
    if (test(j)) set->push_back(static_cast<std::uint32_t>(j));
  }
}

void add(const EigenCloud& c, std::size_t j, double weight, EigenMoments* moments) {
  moments->weight += weight;
  moments->source += weight * c.source[j];
  moments->target += weight * c.target[j];
  moments->cross += weight * c.target[j] * c.source[j].transpose();
}

}  // namespace

std::uint32_t length_count(const EigenCloud& c, std::uint32_t seed, double bound) {
  return count(c, [&](std::size_t j) { return length_consistent(c, seed, j, bound); });
}

std::uint32_t angle_count(const EigenCloud& c, std::uint32_t first, std::uint32_t second, double bound) {
  return count(c, [&](std::size_t m) { return angle_consistent(c, first, second, m, bound); });
}

std::uint32_t alignment_count(const EigenCloud& c, const EigenPose& pose, double bound) {
  return count(c, [&](std::size_t j) { return residual(c, pose, j) < bound; });
}

void length_set(const EigenCloud& c, std::uint32_t seed, double bound, std::vector<std::uint32_t>* set) {
  collect(
      c, [&](std::size_t j) { return length_consistent(c, seed, j, bound); }, set);
}

void angle_set(const EigenCloud& c, std::uint32_t first, std::uint32_t second, double bound,
               std::vector<std::uint32_t>* set) {
  collect(
      c, [&](std::size_t m) { return angle_consistent(c, first, second, m, bound); }, set);
}

void alignment_set(const EigenCloud& c, const EigenPose& pose, double bound, std::vector<std::uint32_t>* set) {
  collect(
      c, [&](std::size_t j) { return residual(c, pose, j) < bound; }, set);
}

double alignment_score(const EigenCloud& c, const EigenPose& pose, double bound) {
  double score = 0.0;
  for (std::size_t j = 0; j < c.source.size(); ++j) {
    const double r = residual(c, pose, j);
    if (r < bound) score += 1.0 - r * r / (bound * bound);
  }
  return score;
}

EigenMoments weighted_moments(const EigenCloud& c, const float* weights) {
  EigenMoments moments;
  for (std::size_t j = 0; j < c.source.size(); ++j) add(c, j, static_cast<double>(weights[j]), &moments);
  return moments;
}

EigenMoments subset_moments(const EigenCloud& c, const std::vector<std::uint32_t>& rows) {
  EigenMoments moments;
  for (const std::uint32_t j : rows) add(c, j, 1.0, &moments);
  return moments;
}

EigenMoments cauchy_moments(const EigenCloud& c, const EigenPose& pose, double scale, double cutoff) {
  EigenMoments moments;
  for (std::size_t j = 0; j < c.source.size(); ++j) {
    const double r = residual(c, pose, j);
    if (r < cutoff) add(c, j, 1.0 / (1.0 + r * r / (scale * scale)), &moments);
  }
  return moments;
}

EigenPose three_point_fit(const EigenCloud& c, const std::uint32_t (&rows)[3]) {
  Eigen::Matrix3d source, target;
  for (int k = 0; k < 3; ++k) {
    source.col(k) = c.source[rows[k]];
    target.col(k) = c.target[rows[k]];
  }
  const Eigen::Vector3d source_mean = source.rowwise().mean();
  const Eigen::Vector3d target_mean = target.rowwise().mean();
  const Eigen::Matrix3d cross = (target.colwise() - target_mean) * (source.colwise() - source_mean).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  const Eigen::Matrix3d R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  return {R, target_mean - R * source_mean};
}

void consistency_matrix(const EigenCloud& c, double bound, std::vector<char>* matrix) {
  const auto n = static_cast<Eigen::Index>(c.source.size());
  matrix->resize(c.source.size() * c.source.size());
  Eigen::Map<Eigen::Matrix<char, Eigen::Dynamic, Eigen::Dynamic>> consistent(matrix->data(), n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = 0; i <= j; ++i) {
      consistent(i, j) = length_consistent(c, static_cast<std::size_t>(i), static_cast<std::size_t>(j), bound) ? 1 : 0;
      consistent(j, i) = consistent(i, j);
    }
  }
}

std::uint32_t common_count(const char* a, const char* b, std::size_t size) {
  using Flags = Eigen::Map<const Eigen::Array<char, Eigen::Dynamic, 1>>;
  const auto n = static_cast<Eigen::Index>(size);
  return static_cast<std::uint32_t>((Flags(a, n) * Flags(b, n) != char{0}).count());
}

}  // namespace consimd::bench::eigen
