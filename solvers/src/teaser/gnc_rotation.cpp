#include <consimd/solvers/gnc_rotation.hpp>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include <consimd/kernels/working_length.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "call/option_checks.hpp"
#include "support/points.hpp"

namespace consimd {
namespace {

/// The differences that are measured, made when they are needed: all pairs of thousands of members would fill the
/// memory. Working frame.
class Differences {
 public:
  Differences(const CorrespondenceView& view, std::span<const std::uint32_t> members, GncRotationOptions::Pairs pairs)
      : all_(pairs == GncRotationOptions::Pairs::all) {
    for (const std::uint32_t k : members) {
      sources_.emplace_back(view.source(0)[k], view.source(1)[k], view.source(2)[k]);
      targets_.emplace_back(view.target(0)[k], view.target(1)[k], view.target(2)[k]);
    }
  }

  [[nodiscard]] std::size_t size() const {
    const std::size_t n = sources_.size();
    return all_ ? n * (n - 1) / 2 : n;
  }

  /// Sum of value(a, b) over all differences: in parts that do not depend on threads, added in order.
  template <typename Sum, typename Value>
  [[nodiscard]] Sum sum(const Value& value) const {
    const std::size_t n = sources_.size();
    const std::size_t per_part = all_ ? kRowsPerPart : n;
    std::vector<Sum> parts((n + per_part - 1) / per_part);
    const auto add_part = [&](std::size_t part) {
      Sum& sum = parts[part];
      for (std::size_t i = part * per_part; i < std::min((part + 1) * per_part, n); ++i) {
        const std::size_t end = all_ ? n : i + 2;
        for (std::size_t j = i + 1; j < end; ++j) {
          const std::size_t other = j < n ? j : 0;
          value(sources_[other] - sources_[i], targets_[other] - targets_[i], sum);
        }
      }
    };
    if (parts.size() == 1) {
      add_part(0);
      return parts[0];
    }
    tbb::parallel_for(std::size_t{0}, parts.size(), add_part);
    Sum total{};
    for (const Sum& part : parts) total.add(part);
    return total;
  }

 private:
  static constexpr std::size_t kRowsPerPart = 16;

  bool all_;
  std::vector<Eigen::Vector3d> sources_;
  std::vector<Eigen::Vector3d> targets_;
};

/// What a round gathers.
struct Round {
  double weight = 0.0;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // sum w b a^T
  double cost = 0.0;                                // sum w r^2, before the fit
  double largest = 0.0;                             // r^2
  std::size_t inliers = 0;

  void add(const Round& other) {
    weight += other.weight;
    cross += other.cross;
    cost += other.cost;
    largest = std::max(largest, other.largest);
    inliers += other.inliers;
  }
};

RigidFit rotation_fit(const Round& round) {
  RigidMoments moments{};
  moments.weight = round.weight;
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) moments.cross[3 * a + b] = round.cross(a, b);
  }
  return rigid_fit(moments);
}

double weight_of(double squared, double mu, double squared_bound) {
  if (squared <= mu / (mu + 1.0) * squared_bound) return 1.0;
  if (squared >= (mu + 1.0) / mu * squared_bound) return 0.0;
  return std::sqrt(squared_bound / squared * mu * (mu + 1.0)) - mu;
}

}  // namespace

GncRotation gnc_rotation(const Correspondences& correspondences, std::span<const std::uint32_t> members,
                         const GncRotationOptions& options) {
  detail::require_length("difference_bound", options.difference_bound);
  if (!(options.growth > 1.0) || !std::isfinite(options.growth)) {
    detail::reject_option("growth", options.growth, "a finite number above 1");
  }
  if (!(options.smallest_change >= 0.0)) {
    detail::reject_option("smallest_change", options.smallest_change, "a number not below 0");
  }
  detail::require_near(correspondences, members);
  GncRotation result;
  if (members.size() < 3) return result;
  const Differences differences(correspondences.view(), members, options.pairs);
  result.measurements = differences.size();
  const double bound = working_length(correspondences, options.difference_bound);
  const double squared_bound = bound * bound;

  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  const auto gather = [&](const auto& weight) {
    return differences.sum<Round>([&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, Round& round) {
      const double squared = (b - rotation * a).squaredNorm();
      const double w = weight(squared);
      round.weight += w;
      round.cross += w * b * a.transpose();
      round.cost += w * squared;
      round.largest = std::max(round.largest, squared);
      if (squared < squared_bound) ++round.inliers;
    });
  };
  const auto fit = [&](const Round& round) {
    const RigidFit fitted = rotation_fit(round);
    result.determined = fitted.determined();
    if (result.determined) rotation = fitted.pose.linear();
    return result.determined;
  };

  const auto unweighted = [](double) { return 1.0; };
  if (!fit(gather(unweighted))) return result;
  Round round = gather(unweighted);
  // All within the bound: least squares is the answer.
  const double excess = 2.0 * round.largest - squared_bound;
  if (excess > 0.0) {
    double mu = squared_bound / excess;
    double cost = std::numeric_limits<double>::infinity();
    const double smallest_change = options.smallest_change * squared_bound * static_cast<double>(differences.size());
    while (result.rounds < options.max_rounds) {
      round = gather([&](double squared) { return weight_of(squared, mu, squared_bound); });
      if (std::abs(cost - round.cost) < smallest_change || !fit(round)) break;
      cost = round.cost;
      ++result.rounds;
      mu *= options.growth;
    }
    round = gather(unweighted);
  }
  result.rotation = rotation;
  result.inliers = round.inliers;
  return result;
}

}  // namespace consimd
