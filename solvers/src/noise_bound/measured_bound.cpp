#include "noise_bound/measured_bound.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "support/points.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

// Sources further from their centroid than this, in median distances, say nothing of the extent.
constexpr float kBulk = 32.0F;
constexpr double kLargestBound = 1.0 / 4.0;  // of the extent
// Points closer than this share of their distance from the origin differ by rounding.
constexpr double kResolution = 1e-14;
// The bound is three deviations; measured again until it changes by less than this factor.
constexpr double kDeviations = 3.0;
constexpr double kSettledFactor = 1.05;
constexpr int kMeasurements = 20;

// Root mean square distance of the sources from their centroid, caller's unit. Sources further away than kBulk median
// distances do not count.
double extent(const Correspondences& correspondences) {
  const CorrespondenceView view = correspondences.view();
  if (view.size() == 0) return 0.0;
  std::vector<float> squared(view.size());
  for (std::size_t k = 0; k < view.size(); ++k) squared[k] = squared_distance(source_point(view, k), {});
  std::vector<float> sorted = squared;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  const float limit = *middle > 0.0F ? kBulk * kBulk * *middle : std::numeric_limits<float>::infinity();
  double sum = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* x = view.source(axis);
    for (std::size_t k = 0; k < view.size(); ++k) {
      if (squared[k] <= limit) sum += static_cast<double>(x[k]) * static_cast<double>(x[k]);
    }
  }
  const auto count = std::ranges::count_if(squared, [limit](float square) { return square <= limit; });
  return std::sqrt(sum / static_cast<double>(count)) / view.scale();
}

// Deviation per axis of the residuals of so many supporters about a pose, over that about the pose fitted to them,
// which took six of their degrees of freedom.
double freedom_factor(double supporters) {
  const double residuals = 3.0 * std::max(supporters, 3.0);
  return std::sqrt(residuals / (residuals - 6.0));
}

}  // namespace

bool are_alike(double bound, double other) { return bound < other * kSettledFactor && other < bound * kSettledFactor; }

double largest_bound_of(const Correspondences& correspondences) {
  const double size = extent(correspondences);
  const auto& centroid = correspondences.source_centroid();
  if (!(size > kResolution * Eigen::Map<const Eigen::Vector3d>(centroid.data()).stableNorm())) return 0.0;
  return kLargestBound * size;
}

Attempt measured(const Correspondences& correspondences, const Attempt& attempt) {
  Attempt result = attempt;
  for (int m = 0; m < kMeasurements; ++m) {
    const RefinedPose refined = refine_pose(correspondences, result.pose, {result.bound});
    if (!refined.fit.determined()) break;
    result.pose = to_working_pose(refined.fit.pose);
    const double former = result.bound;
    result.bound =
        std::max(kDeviations * refined.sigma * freedom_factor(refined.inliers), correspondences.resolution());
    if (are_alike(result.bound, former)) break;
  }
  return result;
}

double measured_bound(const Correspondences& correspondences, CloseLooks& looks, const Attempt& attempt) {
  const Attempt at_noise = measured(correspondences, attempt);
  const WorkingPose& pose = at_noise.pose;
  double bound = at_noise.bound;
  if (looks.is_significant(pose, bound) || !looks.is_significant(attempt.pose, attempt.bound)) {
    return bound;
  }
  // The pose of the attempt is the better one where few rows make the weights of a fit extreme.
  while (bound < attempt.bound && !looks.is_significant(pose, bound) && !looks.is_significant(attempt.pose, bound)) {
    bound *= std::numbers::sqrt2;
  }
  return std::min(bound, attempt.bound);
}

Attempt brought_to(const Correspondences& correspondences, const Attempt& attempt, double bound) {
  const PoseCandidate start = scored(correspondences.view(), attempt.pose, bound);
  const PoseCandidate best = widely_optimise(correspondences, start, bound);
  return {bound, best.pose, significance(correspondences, best.pose, bound, Scrutiny::plain).log10_false_poses};
}

}  // namespace consimd::detail
