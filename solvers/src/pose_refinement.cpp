#include <consimd/solvers/pose_refinement.hpp>

#include <algorithm>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/rigid_moments.hpp>

#include "option_checks.hpp"
#include "residual_mixture.hpp"
#include "set_poses.hpp"

namespace consimd {
namespace {

// In noise bounds: correspondences looked at while the pose moves, and residuals that are modelled and weighted.
constexpr double kNeighbourhood = 3.0;
constexpr double kCutoff = 2.0;
// Plain rounds that bring the pose into place, rounds in which the tails are chosen anew, rounds of a mixture fit.
constexpr std::uint32_t kPlainRounds = 3;
constexpr std::uint32_t kChoosingRounds = 6;
constexpr int kMixtureRounds = 30;
// A pose that moves by less than this share of the noise stands still.
constexpr double kStill = 1e-3;

detail::ResidualHistogram histogram(const CorrespondenceView& view, const WorkingPose& pose, double cutoff) {
  detail::ResidualHistogram result{cutoff, {}};
  std::uint32_t below = 0;
  for (std::size_t b = 0; b < detail::kResidualBins; ++b) {
    std::uint32_t count = 0;
    const double bound = cutoff * static_cast<double>(b + 1) / detail::kResidualBins;
    alignment_counts(view, std::span(&pose, 1), bound, std::span(&count, 1));
    result.counts[b] = count - below;
    below = count;
  }
  return result;
}

}  // namespace

RefinedPose refine_pose(const Correspondences& correspondences, const WorkingPose& start,
                        const PoseRefinementOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  // As far as single precision resolves, and no further than the data reach; the kernels do the same.
  const double tau = std::clamp(options.noise_bound, 1e-9 / correspondences.scale(), 16.0 / correspondences.scale());
  const Correspondences near =
      correspondences.subset(detail::pose_inliers(correspondences.view(), start, kNeighbourhood * tau));
  const CorrespondenceView view = near.view();

  RefinedPose refined;
  refined.fit.pose = from_working_pose(start);
  detail::ResidualMixture mixture;
  mixture.scale = tau / 3.0;
  for (WorkingPose pose = start; refined.rounds < options.max_rounds;) {
    RobustWeight weight{.scale = tau, .cutoff = tau};
    if (refined.rounds >= kPlainRounds) {
      const detail::ResidualHistogram residuals = histogram(view, pose, kCutoff * tau);
      mixture = refined.rounds < kPlainRounds + kChoosingRounds
                    ? detail::choose_mixture(residuals, tau / 3.0, kMixtureRounds)
                    : detail::fit_mixture(residuals, mixture.exponent, mixture.scale, kMixtureRounds);
      weight = {WeightFunction::student_uniform, mixture.scale, kCutoff * tau, mixture.odds(), mixture.exponent};
    }
    const RigidFit fit = rigid_fit(robust_moments(view, pose, weight));
    ++refined.rounds;
    if (!fit.determined()) break;
    const double change = (fit.pose.matrix() - refined.fit.pose.matrix()).norm() / correspondences.scale();
    refined.fit = fit;
    pose = to_working_pose(fit.pose);
    if (refined.rounds > kPlainRounds && change < kStill * mixture.scale) break;
  }
  refined.sigma = mixture.scale;
  refined.exponent = mixture.exponent;
  refined.outlier_density = mixture.outlier_density;
  refined.inliers = mixture.inliers;
  return refined;
}

}  // namespace consimd
