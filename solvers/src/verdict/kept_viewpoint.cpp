#include "verdict/kept_viewpoint.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

// Seven numbers are fitted, and a sample tells them.
constexpr std::size_t kFewestRows = 32;
constexpr std::size_t kSampledRows = 128;
// By how much less ranges differ about a sensor. Of 300 sets of 32 uniform rows they differ 0.13 times as much or more
// about the point that was fitted to them, on 42 recorded pairs 0.25 times; where rows keep a range to a hundredth,
// 0.01 to 0.03.
constexpr double kBetter = 0.1;
// Weights are those of the last of so many rounds.
constexpr int kRounds = 5;
// What ranges hardly tell stays near the centroid by this share of the scatter: where heights are kept to a hundredth
// of the range, the height of the viewpoint.
constexpr double kStays = 1e-4;
// In lengths of the clouds: a viewpoint further away sees all of them at one range, and a nearer one is theirs.
constexpr double kFurthest = 1e6;
constexpr double kNearest = 1e-6;

// Ranges of p about v and of q about w are equal where |p|^2 - |q|^2 = 2 v p - 2 w q + c with c = |w|^2 - |v|^2, which
// is linear in v, w and c. They differ by what its two sides differ by, over the sum of the ranges.
class RangeFit {
 public:
  RangeFit(const CorrespondenceView& view, std::size_t step) {
    for (std::size_t row = 0; row < view.size(); row += step) {
      const Point p = source_point(view, row);
      const Point q = target_point(view, row);
      pairs_.push_back({{p.x, p.y, p.z}, {q.x, q.y, q.z}});
    }
  }

  // By how much ranges differ in the median, about the best v and w, or about a v that is given.
  double best() { return fit<7>(Eigen::Vector3d::Zero()); }
  double about(const Eigen::Vector3d& v) { return fit<4>(v); }

  // The same of mismatched pairs, about the v and w of the last fit.
  [[nodiscard]] double of_mismatched() {
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const Pair& other = pairs_[(k + pairs_.size() / 2) % pairs_.size()];
      pairs_[k].differ = std::abs((pairs_[k].p - v_).norm() - (other.q - w_).norm());
    }
    return median_difference();
  }

  // The v of the last fit.
  [[nodiscard]] const Eigen::Vector3d& viewpoint() const { return v_; }

 private:
  struct Pair {
    Eigen::Vector3d p, q;
    double ranges = 0.0;  // their sum
    double differ = 0.0;
  };

  // Of v, w and c the last `unknowns` are fitted.
  template <int unknowns>
  double fit(const Eigen::Vector3d& v) {
    v_ = v;
    w_.setZero();
    double median = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Matrix<double, unknowns, unknowns> scatter = Eigen::Matrix<double, unknowns, unknowns>::Zero();
      Eigen::Matrix<double, unknowns, 1> sum = Eigen::Matrix<double, unknowns, 1>::Zero();
      for (Pair& pair : pairs_) {
        pair.ranges = std::max((pair.p - v_).norm() + (pair.q - w_).norm(), kNearest);
        // At first all count alike, then little that differ by more than the median.
        const double squared = round == 0 ? 1.0 : median * median + pair.differ * pair.differ;
        const double weight = 1.0 / (pair.ranges * pair.ranges * squared);
        const Eigen::Matrix<double, unknowns, 1> factors = factors_of<unknowns>(pair);
        scatter += weight * factors * factors.transpose();
        sum += weight * side_of<unknowns>(pair, v) * factors;
      }
      scatter.diagonal().array() += kStays * scatter.trace();
      const Eigen::Matrix<double, unknowns, 1> found = scatter.ldlt().solve(sum);
      if (!found.allFinite()) break;
      if constexpr (unknowns == 7) v_ = found.template head<3>();
      w_ = found.template segment<3>(unknowns - 4);
      for (Pair& pair : pairs_) {
        pair.ranges = std::max((pair.p - v_).norm() + (pair.q - w_).norm(), kNearest);
        pair.differ = std::abs(factors_of<unknowns>(pair).dot(found) - side_of<unknowns>(pair, v)) / pair.ranges;
      }
      median = median_difference();
      if (!(median > 0.0)) break;
    }
    return median;
  }

  // The pairs keep their order, and so sums over them their bits with any standard library.
  [[nodiscard]] double median_difference() const {
    std::vector<double> differences(pairs_.size());
    std::ranges::transform(pairs_, differences.begin(), &Pair::differ);
    const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::ranges::nth_element(differences, middle);
    return *middle;
  }

  template <int unknowns>
  static Eigen::Matrix<double, unknowns, 1> factors_of(const Pair& pair) {
    Eigen::Matrix<double, 7, 1> factors;
    factors << 2.0 * pair.p, -2.0 * pair.q, 1.0;
    return factors.tail<unknowns>();
  }

  // What the factors are to come to.
  template <int unknowns>
  static double side_of(const Pair& pair, const Eigen::Vector3d& v) {
    const double squares = pair.p.squaredNorm() - pair.q.squaredNorm();
    return unknowns == 7 ? squares : squares - 2.0 * v.dot(pair.p);
  }

  std::vector<Pair> pairs_;
  Eigen::Vector3d v_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_ = Eigen::Vector3d::Zero();
};

}  // namespace

Eigen::Vector3d kept_viewpoint(const Correspondences& correspondences) {
  const CorrespondenceView view = correspondences.view();
  const Eigen::Vector3d given = view.scale() * (Eigen::Vector3d(correspondences.source_viewpoint().data()) -
                                                Eigen::Vector3d(correspondences.source_centroid().data()));
  if (view.size() < kFewestRows || !(given.squaredNorm() < kFurthest * kFurthest)) return given;
  RangeFit fit(view, std::max<std::size_t>(1, view.size() / kSampledRows));
  const double kept = fit.best();
  const Eigen::Vector3d best = fit.viewpoint();
  return kept < kBetter * fit.of_mismatched() && kept < kBetter * fit.about(given) ? best : given;
}

}  // namespace consimd::detail
