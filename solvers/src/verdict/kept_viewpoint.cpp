#include "verdict/kept_viewpoint.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

// Seven numbers are fitted: fewer rows come close to any.
constexpr std::size_t kFewestRows = 32;
// A step through the rows leaves so many or up to twice as many, which tell a sensor to a part of its rows' noise.
constexpr std::size_t kSampledRows = 128;
// By how much less ranges differ about a sensor. Of 10 000 sets of 32 uniform rows they differ 0.21 times as much or
// more about the point that was fitted to them, on 42 recorded pairs 0.5 times or more; where rows keep a range to a
// hundredth, 0.01 times at most.
constexpr double kBetter = 0.1;
// Rounds of reweighting, the first of which has equal weights. Ten times as many about a given viewpoint, which is
// rarely asked: it is not to be given up for what some rounds more would come to.
constexpr int kRounds = 5;
// Where ranges still differ by half of what chance gives after the first rounds, as among random rows, the others are
// spared.
constexpr int kFirstRounds = 2;
constexpr double kHopeful = 0.5;
constexpr int kRoundsAboutGiven = 50;
// A ridge for what ranges hardly tell: where heights are kept to a hundredth of the range, the height of the viewpoint,
// which stays near the centroid's by it. About a given viewpoint nothing is to be held, and rounding alone asks for
// one.
constexpr double kRidge = 1e-4;
constexpr double kRidgeOfRounding = 1e-12;
// In lengths of the clouds. A viewpoint further away sees all of them at one range.
constexpr double kFurthest = 1e6;
// No range of a pair is taken to be less, so that none is a divisor of zero.
constexpr double kLeastRange = 1e-6;
// Mismatched pairs of so many shifts tell how ranges differ by chance; a copy of the rows may lie at one of them.
constexpr std::size_t kShifts = 3;

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

  // These tell by how much ranges differ in the median, about the best v and w or about a v that is given and the best
  // w.
  double best(int rounds) {
    fit<7>(Eigen::Vector3d::Zero(), rounds);
    return difference(0);
  }
  double about(const Eigen::Vector3d& v) {
    fit<4>(v, kRoundsAboutGiven);
    return difference(0);
  }

  // This tells the same of mismatched pairs, about the v and w of the last fit.
  [[nodiscard]] double of_mismatched() const {
    double largest = 0.0;
    for (std::size_t s = 1; s <= kShifts; ++s) {
      largest = std::max(largest, difference(1 + s * (pairs_.size() - 1) / (kShifts + 1)));
    }
    return largest;
  }

  // The v of the last fit.
  [[nodiscard]] const Eigen::Vector3d& viewpoint() const { return v_; }

 private:
  struct Pair {
    Eigen::Vector3d p, q;
  };

  // The last `unknowns` of v, w and c are fitted, with Cauchy's weights at the median.
  template <int unknowns>
  void fit(const Eigen::Vector3d& v, int rounds) {
    using Vector = Eigen::Matrix<double, unknowns, 1>;
    v_ = v;
    w_.setZero();
    std::vector<double> differences(pairs_.size(), 1.0);
    double spread = 0.0;
    for (int round = 0; round < rounds; ++round) {
      Eigen::Matrix<double, unknowns, unknowns> scatter = Eigen::Matrix<double, unknowns, unknowns>::Zero();
      Vector sum = Vector::Zero();
      for (std::size_t k = 0; k < pairs_.size(); ++k) {
        const double ranges = sum_of_ranges(pairs_[k]);
        const double weight = 1.0 / (ranges * ranges * (spread * spread + differences[k] * differences[k]));
        const Vector factors = factors_of<unknowns>(pairs_[k]);
        scatter += weight * factors * factors.transpose();
        sum += weight * side_of<unknowns>(pairs_[k], v) * factors;
      }
      scatter.diagonal().array() += (unknowns == 7 ? kRidge : kRidgeOfRounding) * scatter.trace();
      const Vector found = scatter.ldlt().solve(sum);
      if (!found.allFinite()) break;
      if constexpr (unknowns == 7) v_ = found.template head<3>();
      w_ = found.template segment<3>(unknowns - 4);
      for (std::size_t k = 0; k < pairs_.size(); ++k) {
        const double sides = factors_of<unknowns>(pairs_[k]).dot(found) - side_of<unknowns>(pairs_[k], v);
        differences[k] = std::abs(sides) / sum_of_ranges(pairs_[k]);
      }
      spread = median(differences);
      if (!(spread > 0.0)) break;
    }
  }

  // How far |p - v| - |q - w|, of each p and the q of the pair `shift` further on, is from its median, in the median:
  // noise moves the w of a far v along its direction by more than it changes what ranges differ by.
  [[nodiscard]] double difference(std::size_t shift) const {
    std::vector<double> differences(pairs_.size());
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      differences[k] = (pairs_[k].p - v_).norm() - (pairs_[(k + shift) % pairs_.size()].q - w_).norm();
    }
    const double middle = median(differences);
    for (double& difference : differences) difference = std::abs(difference - middle);
    return median(std::move(differences));
  }

  [[nodiscard]] double sum_of_ranges(const Pair& pair) const {
    return std::max((pair.p - v_).norm() + (pair.q - w_).norm(), kLeastRange);
  }

  // A copy is partly sorted: the pairs keep their order, and sums over them their bits with any standard library.
  static double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
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
  Eigen::Vector3d given = view.scale() * (Eigen::Vector3d(correspondences.source_viewpoint().data()) -
                                          Eigen::Vector3d(correspondences.source_centroid().data()));
  if (view.size() < kFewestRows || !correspondences.far_rows().empty()) return given;
  RangeFit fit(view, std::max<std::size_t>(1, view.size() / kSampledRows));
  if (!(fit.best(kFirstRounds) < kHopeful * fit.of_mismatched())) return given;
  const double kept = fit.best(kRounds);
  Eigen::Vector3d best = fit.viewpoint();
  if (!(kept < kBetter * fit.of_mismatched())) return given;
  const bool is_seen_from_afar = !(given.squaredNorm() < kFurthest * kFurthest);
  return is_seen_from_afar || kept < kBetter * fit.about(given) ? best : given;
}

}  // namespace consimd::detail
