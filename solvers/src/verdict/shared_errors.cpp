#include "verdict/shared_errors.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <optional>

#include "support/source_scatter.hpp"

namespace consimd::detail {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Supporters looked at. Among more each k-th row is, which makes shared errors count for a k-th.
constexpr double kSupporters = 512.0;
// Components of the differences of halves along three axes, and what their mean square exceeds once in fifty times if
// residuals are independent: a chi-square variable of 18 degrees of freedom over 18.
constexpr double kIndependent = 1.797;
// A pivot of a normal matrix below this share of its diagonal element is no more than rounding: points on a line.
constexpr double kSingular = 1e-9;

/// A plain weight of robust_moments, in double precision.
double student_uniform_weight(const RobustWeight& weight, double squared_over_scale) {
  const double y = 1.0 + squared_over_scale / (2.0 * weight.exponent);
  double power = y;
  for (std::uint32_t e = weight.exponent; e > 1; e /= 2) power *= power;
  return 1.0 / (y * (1.0 + weight.odds * power));
}

/// Sums over the supporters in a part of the scene, about a common centre.
struct Part {
  double weight = 0.0;
  Eigen::Vector3d source = Eigen::Vector3d::Zero();   // w x
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();  // w x x^T
  Vector6d score = Vector6d::Zero();                  // w (x cross e, e)

  void add(double w, const Eigen::Vector3d& x, const Eigen::Vector3d& e) {
    weight += w;
    source += w * x;
    scatter += w * x * x.transpose();
    score.head<3>() += w * x.cross(e);
    score.tail<3>() += w * e;
  }

  Part& operator+=(const Part& other) {
    weight += other.weight;
    source += other.source;
    scatter += other.scatter;
    score += other.score;
    return *this;
  }

  /// score^T G^-1 score, G the normal matrix; none if the part does not determine a pose.
  [[nodiscard]] std::optional<double> squares() const {
    Matrix6d normal = Matrix6d::Zero();
    normal.topLeftCorner<3, 3>() = scatter.trace() * Eigen::Matrix3d::Identity() - scatter;
    normal.bottomLeftCorner<3, 3>() << 0.0, source[2], -source[1], -source[2], 0.0, source[0], source[1], -source[0],
        0.0;
    normal.bottomRightCorner<3, 3>().diagonal().setConstant(weight);
    const Eigen::LLT<Matrix6d> factors(normal);  // reads the lower triangle
    if (factors.info() != Eigen::Success) return std::nullopt;
    const Vector6d pivots = factors.matrixLLT().diagonal().cwiseAbs2();
    if (!(pivots.array() > kSingular * normal.diagonal().array()).all()) return std::nullopt;
    return factors.matrixL().solve(score).squaredNorm();
  }
};

/// The supporters in the eight octants about their centroid, bit a of an octant's number: the side along axis a.
struct Octants {
  std::array<Part, 8> parts;
  double variance = 0.0;  ///< of a score per unit of the normal matrix, if residuals are independent

  /// The sum over the octants whose number has the bits `value` under `mask`.
  [[nodiscard]] Part sum(unsigned mask, unsigned value) const {
    Part result;
    for (unsigned octant = 0; octant < parts.size(); ++octant) {
      if ((octant & mask) == value) result += parts[octant];
    }
    return result;
  }
};

Octants octants(const CorrespondenceView& view, const RobustWeight& weight, const RigidMoments& moments,
                const RigidTransform& pose, std::size_t stride) {
  const double scale = weight.scale * view.scale();
  const double cutoff = weight.cutoff * view.scale();
  const Eigen::Matrix3d rotation = pose.linear();
  const Eigen::Vector3d translation = pose.translation();
  const Eigen::Vector3d centre = rotation * Eigen::Map<const Eigen::Vector3d>(moments.source) / moments.weight;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(central_source_scatter(moments));
  const Eigen::Matrix3d axes = (rotation * principal.eigenvectors()).transpose();

  Octants result;
  double total = 0.0;
  double squares = 0.0;
  for (std::size_t k = 0; k < view.size(); k += stride) {
    const Eigen::Vector3d moved = rotation * Eigen::Vector3d(view.source(0)[k], view.source(1)[k], view.source(2)[k]);
    const Eigen::Vector3d e =
        Eigen::Vector3d(view.target(0)[k], view.target(1)[k], view.target(2)[k]) - moved - translation;
    const double squared = e.squaredNorm();
    if (!(squared < cutoff * cutoff)) continue;
    const double w = student_uniform_weight(weight, squared / (scale * scale));
    const Eigen::Vector3d x = moved - centre;
    const Eigen::Vector3d along = axes * x;
    const unsigned octant = (along[0] > 0.0 ? 1U : 0U) | (along[1] > 0.0 ? 2U : 0U) | (along[2] > 0.0 ? 4U : 0U);
    result.parts[octant].add(w, x, e);
    total += w;
    squares += w * w * squared;
  }
  // Six fitted parameters make the residuals smaller.
  result.variance = squares / std::max(3.0 * total - 6.0, 1.0);
  return result;
}

/// Sums of squares between the two parts of a pair, and pairs counted.
struct Differences {
  double squares = 0.0;
  int pairs = 0;

  void add(const std::optional<double>& whole, const std::optional<double>& one, const std::optional<double>& other) {
    if (!whole || !one || !other) return;
    squares += *one + *other - *whole;
    ++pairs;
  }

  /// Mean square of a component, for each k-th row extended to all rows.
  [[nodiscard]] double mean_square(double variance, std::size_t stride) const {
    const double seen = squares / (6.0 * pairs * variance);
    return 1.0 + static_cast<double>(stride) * (seen - 1.0);
  }
};

}  // namespace

double shared_error_factor(const CorrespondenceView& view, const RobustWeight& weight, const RigidMoments& moments,
                           const RigidTransform& pose) {
  if (weight.function != WeightFunction::student_uniform || !(moments.weight > 0.0)) return 1.0;
  const auto stride = static_cast<std::size_t>(moments.weight / kSupporters) + 1;
  const Octants scene = octants(view, weight, moments, pose, stride);
  if (!(scene.variance > 0.0)) return 1.0;

  const std::optional<double> whole = scene.sum(0, 0).squares();
  Differences halves;
  Differences quarters;
  for (unsigned axis = 1; axis < 8; axis *= 2) {
    const std::array<std::optional<double>, 2> half{scene.sum(axis, 0).squares(), scene.sum(axis, axis).squares()};
    halves.add(whole, half[0], half[1]);
    for (unsigned other = 1; other < 8; other *= 2) {
      if (other == axis) continue;
      for (unsigned side = 0; side < 2; ++side) {
        const unsigned value = side * axis;
        quarters.add(half[side], scene.sum(axis | other, value).squares(),
                     scene.sum(axis | other, value | other).squares());
      }
    }
  }
  if (halves.pairs == 0 || halves.mean_square(scene.variance, 1) < kIndependent) return 1.0;
  const double of_halves = halves.mean_square(scene.variance, stride);
  if (quarters.pairs == 0) return of_halves;
  return of_halves * std::max(1.0, of_halves / std::max(1.0, quarters.mean_square(scene.variance, stride)));
}

}  // namespace consimd::detail
