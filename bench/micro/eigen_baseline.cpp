#include "eigen_baseline.hpp"

#include <cstddef>

#include "eigen_geometry.hpp"

namespace consimd::bench::eigen {
namespace {

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
  return kabsch(cross, source_mean, target_mean);
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
