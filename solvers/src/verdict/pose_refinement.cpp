#include <consimd/solvers/pose_refinement.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/kernels/working_length.hpp>

#include "call/option_checks.hpp"
#include "support/pose_candidate.hpp"
#include "support/row_blocks.hpp"
#include "verdict/fit_covariance.hpp"
#include "verdict/residual_mixture.hpp"
#include "verdict/shared_errors.hpp"

namespace consimd {
namespace {

// In noise bounds: correspondences looked at while the pose moves, and residuals that are modelled and weighted.
constexpr double kNeighbourhood = 3.0;
constexpr double kCutoff = 2.0;
// Plain rounds that bring the pose into place, rounds in which the tails are chosen anew; rounds of the first mixture
// fit, and of those that start where the last one ended.
constexpr std::uint32_t kPlainRounds = 3;
constexpr std::uint32_t kChoosingRounds = 6;
constexpr int kFirstMixtureRounds = 30;
constexpr int kMixtureRounds = 6;
// A bound below so many deviations of the noise hides its tails: when it is smaller by the second factor it is widened,
// up to the third.
constexpr double kDeviations = 3.0;
constexpr double kTooTight = 1.6;
constexpr double kWidest = 2.0;
// A pose that moves by less than this share of the noise stands still.
constexpr double kStill = 1e-3;

detail::ResidualHistogram histogram(const CorrespondenceView& view, const WorkingPose& pose, double cutoff,
                                    std::vector<float>& squared) {
  squared.resize(view.words() * kBlock);
  alignment_residuals(view, pose, squared);
  detail::ResidualHistogram result{cutoff, {}};
  const auto bins = static_cast<float>(detail::kResidualBins);
  const float bins_per_length = bins / static_cast<float>(cutoff * view.scale());
  for (std::size_t j = 0; j < view.size(); ++j) {
    const float bin = std::sqrt(squared[j]) * bins_per_length;
    if (bin < bins) ++result.counts[static_cast<std::size_t>(bin)];
  }
  return result;
}

RefinedPose refine_within(const Correspondences& correspondences, const WorkingPose& start, double tau,
                          std::uint32_t max_rounds) {
  const Correspondences near =
      correspondences.subset(detail::pose_inliers(correspondences.view(), start, kNeighbourhood * tau));
  const CorrespondenceView view = near.view();

  std::vector<float> squared;  // scratch of the histogram
  RefinedPose refined;
  refined.fit.pose = from_working_pose(start);
  RigidMoments moments{};  // that gave refined.fit
  RobustWeight weight;     // that gave the moments
  std::optional<detail::MixtureChoice> choice;
  detail::ResidualMixture mixture;
  mixture.scale = tau / kDeviations;
  for (WorkingPose pose = start; refined.rounds < max_rounds;) {
    RobustWeight next{.scale = tau, .cutoff = tau};
    if (refined.rounds >= kPlainRounds) {
      const detail::ResidualHistogram residuals = histogram(view, pose, kCutoff * tau, squared);
      const int mixture_rounds = choice ? kMixtureRounds : kFirstMixtureRounds;
      if (!choice) choice.emplace(residuals, tau / kDeviations);
      if (refined.rounds < kPlainRounds + kChoosingRounds) {
        mixture = choice->fit(residuals, mixture_rounds);
      } else {
        detail::fit_mixture(residuals, mixture, mixture_rounds);
      }
      next = {WeightFunction::student_uniform, mixture.scale, kCutoff * tau, mixture.odds(), mixture.exponent};
    }
    const RigidMoments next_moments = detail::row_blocks::robust_moments(view, pose, next);
    const RigidFit fit = rigid_fit(next_moments);
    ++refined.rounds;
    if (!fit.determined()) break;
    moments = next_moments;
    weight = next;
    const double change = (fit.pose.matrix() - refined.fit.pose.matrix()).norm() / correspondences.scale();
    refined.fit = fit;
    pose = to_working_pose(fit.pose);
    if (refined.rounds > kPlainRounds && change < kStill * mixture.scale) break;
  }
  refined.sigma = mixture.scale;
  refined.exponent = mixture.exponent;
  refined.outlier_density = mixture.outlier_density;
  refined.inliers = mixture.inliers;
  const double shared = detail::shared_error_factor(view, weight, moments, refined.fit.pose);
  refined.covariance = detail::fit_covariance(moments, weight, refined.fit.pose, correspondences, shared);
  const detail::ScaleFit scale = detail::fit_scale(moments, weight, refined.fit.pose, shared);
  refined.scale = scale.scale;
  refined.scale_deviation = scale.deviation;
  refined.shared_errors = shared;
  refined.centre = scale.centre;
  return refined;
}

}  // namespace

RefinedPose refine_pose(const Correspondences& correspondences, const WorkingPose& start,
                        const PoseRefinementOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  const double tau = working_length(correspondences, options.noise_bound) / correspondences.scale();
  RefinedPose refined = refine_within(correspondences, start, tau, options.max_rounds);
  const double measured = kDeviations * refined.sigma;
  if (!refined.fit.determined() || measured < kTooTight * tau) return refined;
  RefinedPose wider = refine_within(correspondences, to_working_pose(refined.fit.pose),
                                    std::min(measured, kWidest * tau), options.max_rounds);
  wider.rounds += refined.rounds;
  return wider.fit.determined() ? wider : refined;
}

}  // namespace consimd
