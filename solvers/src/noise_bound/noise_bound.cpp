#include <consimd/solvers/noise_bound.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "call/distinct_rows.hpp"
#include "search/consensus_search.hpp"
#include "support/points.hpp"
#include "verdict/pose_test.hpp"

namespace consimd {
namespace {

// Sources further from their centroid than this, in median distances, say nothing of the extent.
constexpr float kBulk = 32.0F;
constexpr double kLeastBound = 1.0 / 2048.0;  // of the extent
constexpr std::uint32_t kBounds = 10;
// Points closer than this share of their distance from the origin differ by rounding.
constexpr double kResolution = 1e-14;
constexpr std::uint32_t kSeeds = 1024;
// Bounds tried after the most significant one before it is believed to be that.
constexpr int kBoundsPastTheLeast = 3;
// The bound is three deviations; measured again until it changes by less than this factor.
constexpr double kDeviations = 3.0;
constexpr double kSettledFactor = 1.05;
constexpr int kMeasurements = 10;

// Root mean square distance of the sources from their centroid, caller's unit. Sources further away than kBulk median
// distances do not count.
double extent(const Correspondences& correspondences) {
  const CorrespondenceView view = correspondences.view();
  if (view.size() == 0) return 0.0;
  std::vector<float> squared(view.size());
  for (std::size_t k = 0; k < view.size(); ++k) squared[k] = squared_distance(detail::source_point(view, k), {});
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

// Three times the scale of the residuals around the pose, from the bound that it was found with.
double measured_bound(const Correspondences& correspondences, WorkingPose pose, double bound) {
  for (int m = 0; m < kMeasurements; ++m) {
    const RefinedPose refined = refine_pose(correspondences, pose, {bound});
    if (!refined.fit.determined()) break;
    pose = to_working_pose(refined.fit.pose);
    const double former = bound;
    bound = kDeviations * refined.sigma;
    if (bound < former * kSettledFactor && former < bound * kSettledFactor) break;
  }
  return bound;
}

// The best pose at one bound.
struct Attempt {
  double bound;
  detail::PoseCandidate best;
  double log10_false_poses;
};

detail::ConsensusSearchOptions options_for(double bound, std::uint64_t seed) {
  return {.noise_bound = bound, .seed = seed, .max_seeds = kSeeds};
}

// By the closed form of the significance.
std::vector<Attempt> attempts(const Correspondences& correspondences, double least_bound, std::uint64_t seed) {
  std::vector<Attempt> result;
  double least = detail::kSignificant;
  int since_least = 0;
  double bound = least_bound;
  for (std::uint32_t b = 0; b < kBounds && since_least < kBoundsPastTheLeast; ++b, bound *= 2.0) {
    detail::ConsensusSearch search(correspondences, options_for(bound, seed));
    search.run(false);
    const detail::PoseCandidate& best = search.best();
    if (best.support.count < 3) continue;
    const double log10_false_poses = significance(correspondences, best.pose, bound).log10_false_poses;
    result.push_back({bound, best, log10_false_poses});
    if (log10_false_poses < least) {
      least = log10_false_poses;
      since_least = 0;
    } else if (least < detail::kSignificant) {
      ++since_least;
    }
  }
  return result;
}

}  // namespace

NoiseBoundEstimate estimate_noise_bound(const Correspondences& all, std::uint64_t seed) {
  const detail::DistinctRows rows(all);
  const Correspondences& correspondences = rows.correspondences();
  const double size = extent(correspondences);
  const auto& centroid = correspondences.source_centroid();
  if (!(size > kResolution * std::hypot(centroid[0], centroid[1], centroid[2]))) return {1.0, 0.0, 1};
  std::vector<Attempt> tried = attempts(correspondences, kLeastBound * size, seed);
  if (tried.empty()) return {kLeastBound * size, 0.0, kBounds};
  const auto by_chance = [](const Attempt& attempt) { return attempt.log10_false_poses; };
  const double bounds = std::log10(kBounds);
  const auto chosen = std::ranges::min_element(tried, {}, by_chance);
  if (chosen->log10_false_poses < detail::kSignificant) {
    return {measured_bound(correspondences, chosen->best.pose, chosen->bound), chosen->log10_false_poses + bounds,
            kBounds};
  }
  return {chosen->bound, chosen->log10_false_poses + bounds, kBounds};  // too few supporters to measure
}

}  // namespace consimd
