#include "refinement/normal_equations.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace consimd::features::detail {
namespace {

// Variance along a normal over that across, of each point (Segal 2009, section III-C).
constexpr double kAlongNormal = 1e-3;
// Cauchy's constant, in deviations, of 95 % efficiency for Gaussian residuals.
constexpr double kCauchy = 2.3849;
// Residuals are not told apart below the rounding of coordinates of up to 1 in single precision.
constexpr double kSmallestScale = 0x1p-23;

/// The normal of a point; NaN where there is none.
Eigen::Vector3d normal_of(const CloudView& cloud, std::size_t row) {
  return {static_cast<double>(cloud.normals(0)[row]), static_cast<double>(cloud.normals(1)[row]),
          static_cast<double>(cloud.normals(2)[row])};
}

}  // namespace

double pair_weight(double squared, double squared_scale) noexcept {
  return 1.0 / (1.0 + squared / (kCauchy * kCauchy * squared_scale));
}

void NormalEquations::add(const PairTerm& term, double squared_scale) {
  const double w = pair_weight(term.squared, squared_scale);
  const Eigen::Vector3d& a = term.arm;
  weight += w;
  spread += w * a.squaredNorm();
  squared_score += w * w * term.squared;
  slope += w * (2.0 * w - 1.0);
  ++pairs;
  if (term.of_plane) {
    const Eigen::Vector3d lever = a.cross(term.normal);
    const double row[6] = {lever[0], lever[1], lever[2], term.normal[0], term.normal[1], term.normal[2]};
    const double force = w * term.normal.dot(term.error);
    for (int r = 0; r < 6; ++r) {
      score[r] += force * row[r];
      const double weighted = w * row[r];
      for (int c = 0; c <= r; ++c) normal(r, c) += weighted * row[c];
    }
    return;
  }
  const Eigen::Matrix3d m = w * term.metric;
  // [a]x m, a column at a time, and [a]x m [a]x^T.
  Eigen::Matrix3d turned;
  for (int c = 0; c < 3; ++c) turned.col(c) = a.cross(m.col(c));
  for (int r = 0; r < 3; ++r) normal.block<1, 3>(r, 0) += a.cross(turned.row(r).transpose()).transpose();
  normal.bottomLeftCorner<3, 3>() += turned.transpose();
  normal.bottomRightCorner<3, 3>() += m;
  const Eigen::Vector3d force = m * term.error;
  score.head<3>() += a.cross(force);
  score.tail<3>() += force;
}

NormalEquations& NormalEquations::operator+=(const NormalEquations& other) {
  normal += other.normal;
  score += other.score;
  weight += other.weight;
  spread += other.spread;
  squared_score += other.squared_score;
  slope += other.slope;
  squared_length += other.squared_length;
  pairs += other.pairs;
  return *this;
}

bool PairTerms::term(std::size_t i, PairTerm& term) const {
  const std::uint32_t row = pairs_.target_row(i);
  if (row == ClosestPairs::kNone) return false;
  const Eigen::Vector3d x = pairs_.moved(i);
  term.arm = x - centre_;
  term.error =
      x - Eigen::Vector3d(static_cast<double>(target_.points(0)[row]), static_cast<double>(target_.points(1)[row]),
                          static_cast<double>(target_.points(2)[row]));
  term.of_plane = method_ == RefinementMethod::plane;
  if (method_ == RefinementMethod::point) {
    term.metric.setIdentity();
    term.squared = term.error.squaredNorm();
    return true;
  }
  const Eigen::Vector3d n = normal_of(target_, row);
  if (!(n[0] == n[0])) return false;  // NOLINT(misc-redundant-expression): NaN
  if (method_ == RefinementMethod::plane) {
    const double along = n.dot(term.error);
    term.normal = n;
    term.squared = along * along;
    return true;
  }
  const Eigen::Vector3d own = rotation_ * normal_of(source_, pairs_.source_row(i));
  if (!(own[0] == own[0])) return false;  // NOLINT(misc-redundant-expression): NaN
  // The sum of both covariances, inverted, in units of its largest eigenvalue for equal normals.
  const Eigen::Matrix3d covariance =
      2.0 * Eigen::Matrix3d::Identity() - (1.0 - kAlongNormal) * (n * n.transpose() + own * own.transpose());
  term.metric = 2.0 * kAlongNormal * covariance.inverse();
  term.squared = term.error.dot(term.metric * term.error);
  return true;
}

double PairTerms::scale() const {
  constexpr std::size_t kLooked = 4000;
  const std::size_t step = std::max<std::size_t>(1, pairs_.size() / kLooked);
  std::vector<double> squared;
  squared.reserve(pairs_.size() / step + 1);
  PairTerm one;
  for (std::size_t i = 0; i < pairs_.size(); i += step) {
    if (term(i, one)) squared.push_back(one.squared);
  }
  if (squared.empty()) return 0.0;
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  // Medians of |r| in deviations an axis: of one Gaussian component, and of the length of three.
  const double median = method_ == RefinementMethod::plane ? 0.6745 : 1.5382;
  return std::max(std::sqrt(*middle) / median, kSmallestScale);
}

NormalEquations PairTerms::sum(double scale) const {
  const std::size_t blocks = (pairs_.size() + kPairBlock - 1) / kPairBlock;
  std::vector<NormalEquations> sums(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    NormalEquations& sum = sums[block];
    PairTerm one;
    const std::size_t end = std::min(pairs_.size(), (block + 1) * kPairBlock);
    for (std::size_t i = block * kPairBlock; i < end; ++i) {
      if (!term(i, one)) continue;
      sum.add(one, scale * scale);
      sum.squared_length += method_ == RefinementMethod::plane ? one.squared : one.error.squaredNorm();
    }
  });
  NormalEquations total;
  for (const NormalEquations& sum : sums) total += sum;
  return total;
}

}  // namespace consimd::features::detail
