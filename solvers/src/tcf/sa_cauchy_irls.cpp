#include <consimd/solvers/sa_cauchy_irls.hpp>

#include <algorithm>
#include <cmath>

#include "call/option_checks.hpp"

namespace consimd {
namespace {

// The members of the stage are few: double precision, straight loops.
class Points {
 public:
  Points(const Correspondences& correspondences, std::span<const std::uint32_t> members) {
    const CorrespondenceView view = correspondences.view();
    for (const std::uint32_t k : members) {
      source_.emplace_back(view.source(0)[k], view.source(1)[k], view.source(2)[k]);
      target_.emplace_back(view.target(0)[k], view.target(1)[k], view.target(2)[k]);
    }
  }

  [[nodiscard]] RigidFit fit(const std::vector<double>& weights) const {
    RigidMoments m{};
    for (std::size_t k = 0; k < source_.size(); ++k) {
      const double w = weights[k];
      m.weight += w;
      for (int a = 0; a < 3; ++a) {
        m.source[a] += w * source_[k][a];
        m.target[a] += w * target_[k][a];
        for (int b = 0; b < 3; ++b) m.cross[3 * a + b] += w * target_[k][a] * source_[k][b];
      }
    }
    return rigid_fit(m);
  }

  // Residuals in the caller's unit.
  void residuals(const RigidTransform& pose, double unit, std::vector<double>& out) const {
    out.resize(source_.size());
    for (std::size_t k = 0; k < source_.size(); ++k) out[k] = (pose * source_[k] - target_[k]).norm() * unit;
  }

 private:
  std::vector<Eigen::Vector3d> source_;
  std::vector<Eigen::Vector3d> target_;
};

constexpr double kPrintedSmallestChange = 0.01;  // e_min of algorithm 3, square metres
constexpr double kPrintedSmallestScale = 1.0;    // gamma_min of algorithm 3, metres

}  // namespace

IrlsResult sa_cauchy_irls(const Correspondences& correspondences, std::span<const std::uint32_t> members,
                          const SaCauchyIrlsOptions& options) {
  const bool as_printed = options.rule == SaCauchyIrlsOptions::Rule::as_printed;
  if (!as_printed) detail::require_length("final_scale", options.final_scale);
  if (!(options.scale_divisor > 1.0)) detail::reject_option("scale_divisor", options.scale_divisor, "a number above 1");
  detail::require_near(correspondences, members);

  IrlsResult result;
  result.members.assign(members.begin(), members.end());
  if (members.empty()) return result;
  const double unit = 1.0 / correspondences.scale();
  const Points points(correspondences, members);
  std::vector<double> weights(members.size(), 1.0);
  std::vector<double> residuals;
  result.fit = points.fit(weights);
  points.residuals(result.fit.pose, unit, residuals);
  double scale = *std::max_element(residuals.begin(), residuals.end());
  double cost = -1.0;

  while (result.rounds < options.max_rounds && result.fit.determined()) {
    result.fit = points.fit(weights);
    ++result.rounds;
    points.residuals(result.fit.pose, unit, residuals);
    double new_cost = 0.0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const double e = residuals[k];
      weights[k] = e < 3.0 * scale ? scale * scale / (scale * scale + (as_printed ? e : e * e)) : 0.0;
      // A perfect fit has scale 0 and residuals 0: full weight, not 0 / 0.
      if (scale == 0.0) weights[k] = 1.0;
      new_cost += weights[k] * e * e;
    }
    const double next_scale = scale / options.scale_divisor;
    const bool done = as_printed ? (cost >= 0.0 && std::abs(new_cost - cost) < kPrintedSmallestChange) ||
                                       next_scale < kPrintedSmallestScale
                                 : next_scale < options.final_scale;
    if (done) break;
    cost = new_cost;
    scale = next_scale;
  }
  result.members.clear();
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] > 0.0) result.members.push_back(members[k]);
  }
  return result;
}

}  // namespace consimd
