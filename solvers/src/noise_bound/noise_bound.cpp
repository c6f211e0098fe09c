#include <consimd/solvers/noise_bound.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

#include "call/distinct_rows.hpp"
#include "search/consensus_search.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/pose_test.hpp"

namespace consimd {
namespace {

// Sources further from their centroid than this, in median distances, say nothing of the extent.
constexpr float kBulk = 32.0F;
constexpr double kLargestBound = 1.0 / 4.0;  // of the extent
constexpr std::uint32_t kBounds = 10;
// Points closer than this share of their distance from the origin differ by rounding.
constexpr double kResolution = 1e-14;
// A pose that a fiftieth of the rows supports is met by the seeds in a sample of the rows.
constexpr std::size_t kSampledRows = 1024;
constexpr std::size_t kSampleGrowth = 4;
// The bound is three deviations; measured again until it changes by less than this factor.
constexpr double kDeviations = 3.0;
constexpr double kSettledFactor = 1.05;
constexpr int kMeasurements = 20;
// Attempts in doubt that are looked at between the bounds as well, and where.
constexpr std::size_t kLookedAtClosely = 3;
constexpr std::array kFinerFactors{std::numbers::sqrt2 / 2.0, std::numbers::sqrt2};

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

// The best pose at one bound.
struct Attempt {
  double bound;
  WorkingPose pose;
  double log10_false_poses;
};

// Deviation per axis of the residuals of so many supporters about a pose, over that about the pose fitted to them,
// which took six of their degrees of freedom.
double freedom_factor(double supporters) {
  const double residuals = 3.0 * std::max(supporters, 3.0);
  return std::sqrt(residuals / (residuals - 6.0));
}

// log10 by which many bounds raise the number of false poses.
double penalty() { return std::log10(kBounds); }

// Whether a registration would find the pose significant, beside what its runner-up may reach.
bool is_significant(const Correspondences& correspondences, const WorkingPose& pose, double bound) {
  if (significance(correspondences, pose, bound, Scrutiny::glance).log10_false_poses + penalty() <
      detail::kBeyondDoubt) {
    return true;
  }
  return significance(correspondences, pose, bound).log10_false_poses + penalty() < detail::kSignificantRival;
}

// Three times the scale of the residuals around the pose, from the bound that it was found with. Where the pose is
// significant with that and is not with what is measured, of what lies between the first that will do.
double measured_bound(const Correspondences& correspondences, const Attempt& attempt) {
  WorkingPose pose = attempt.pose;
  double bound = attempt.bound;
  for (int m = 0; m < kMeasurements; ++m) {
    const RefinedPose refined = refine_pose(correspondences, pose, {bound});
    if (!refined.fit.determined()) break;
    pose = to_working_pose(refined.fit.pose);
    const double former = bound;
    bound = std::max(kDeviations * refined.sigma * freedom_factor(refined.inliers), correspondences.resolution());
    if (bound < former * kSettledFactor && former < bound * kSettledFactor) break;
  }
  if (is_significant(correspondences, pose, bound) || !is_significant(correspondences, attempt.pose, attempt.bound)) {
    return bound;
  }
  // The pose of the attempt is the better one where few rows make the weights of a fit extreme.
  while (bound < attempt.bound && !is_significant(correspondences, pose, bound) &&
         !is_significant(correspondences, attempt.pose, bound)) {
    bound *= kFinerFactors.back();
  }
  return std::min(bound, attempt.bound);
}

// What a search takes upon itself.
struct Effort {
  std::uint32_t seeds;
  // Bounds tried below the most significant one before it is believed to be that. What matchers keep, which pairing at
  // random knows nothing of, may be more significant at larger bounds.
  std::uint32_t bounds_past = kBounds;
  bool exhaustive = false;
};
constexpr Effort kOnSample{256, 3};
constexpr Effort kOnAll{1024};
// As much as a registration that finds nothing at first.
constexpr Effort kLast{detail::ConsensusSearchOptions{}.max_seeds, kBounds, true};

// The best pose and its runner-up at bounds from the largest on, each half of the last. Every search has the poses of
// the last one at hand.
std::vector<Attempt> attempts(const Correspondences& correspondences, double largest_bound, std::uint64_t seed,
                              const Effort& effort) {
  std::vector<Attempt> result;
  std::vector<WorkingPose> known;
  double least = detail::kSignificant;
  std::uint32_t since_least = 0;
  double bound = largest_bound;
  for (std::uint32_t b = 0; b < kBounds && since_least < effort.bounds_past; ++b, bound /= 2.0) {
    detail::ConsensusSearch search(correspondences,
                                   {.noise_bound = bound, .seed = seed, .max_seeds = effort.seeds, .settles = false});
    for (const WorkingPose& pose : known) search.offer(pose);
    search.run(effort.exhaustive);
    known.clear();
    double least_here = 0.0;
    for (const detail::PoseCandidate* found : {&search.poses().best(), &search.poses().runner_up()}) {
      if (found->support.count < 3) continue;
      known.push_back(found->pose);
      const double plain = significance(correspondences, found->pose, bound, Scrutiny::plain).log10_false_poses;
      result.push_back({bound, found->pose, plain});
      least_here = std::min(least_here, plain);
    }
    if (known.empty()) break;
    if (least_here < least) {
      least = least_here;
      since_least = 0;
    } else if (least < detail::kSignificant) {
      ++since_least;
    }
  }
  return result;
}

// The one with the least number of false poses, at the smallest bound of those.
const Attempt& most_significant(const std::vector<Attempt>& tried) {
  return *std::ranges::min_element(
      tried, {}, [](const Attempt& attempt) { return std::pair(attempt.log10_false_poses, attempt.bound); });
}

// The pose of an attempt at another bound, looked at closely.
Attempt brought_to(const Correspondences& correspondences, const Attempt& attempt, double bound) {
  const detail::PoseCandidate start = detail::scored(correspondences.view(), attempt.pose, bound);
  const detail::PoseCandidate best = detail::widely_optimise(correspondences, start, bound);
  return {bound, best.pose, significance(correspondences, best.pose, bound).log10_false_poses};
}

// The most significant of the attempts where structure counts, and of those between the bounds of the first few.
Attempt looked_at_closely(const Correspondences& correspondences, std::vector<Attempt> tried) {
  const auto has_a_chance = [](const Attempt& attempt) { return attempt.log10_false_poses < detail::kSignificant; };
  if (std::ranges::none_of(tried, has_a_chance)) return most_significant(tried);
  std::erase_if(tried, std::not_fn(has_a_chance));  // structure makes no pose more significant
  for (Attempt& attempt : tried) attempt = brought_to(correspondences, attempt, attempt.bound);
  std::ranges::sort(tried, {}, &Attempt::log10_false_poses);
  tried.resize(std::min(tried.size(), kLookedAtClosely));
  for (const Attempt& attempt : std::vector<Attempt>(tried)) {
    for (const double factor : kFinerFactors) {
      tried.push_back(brought_to(correspondences, attempt, factor * attempt.bound));
    }
    tried.push_back(brought_to(correspondences, attempt, measured_bound(correspondences, attempt)));
  }
  return most_significant(tried);
}

// Every so many rows, as many as wanted; all where these are not as many.
Correspondences sample(const Correspondences& correspondences, std::size_t wanted) {
  const std::size_t size = correspondences.size();
  std::vector<std::uint32_t> rows(std::min(size, wanted));
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<std::uint32_t>(k * size / rows.size());
  return correspondences.subset(rows);
}

}  // namespace

NoiseBoundEstimate estimate_noise_bound(const Correspondences& all, std::uint64_t seed) {
  const detail::DistinctRows rows(all);
  const Correspondences& correspondences = rows.correspondences();
  const double size = extent(correspondences);
  const auto& centroid = correspondences.source_centroid();
  if (!(size > kResolution * std::hypot(centroid[0], centroid[1], centroid[2]))) return {1.0, 0.0, 1};
  const double largest_bound = kLargestBound * size;
  // A pose that some of the rows put beyond doubt tells the noise as well as all of them do.
  for (std::size_t wanted = kSampledRows; wanted < correspondences.size(); wanted *= kSampleGrowth) {
    const Correspondences some = sample(correspondences, wanted);
    const std::vector<Attempt> tried = attempts(some, largest_bound, seed, kOnSample);
    if (tried.empty()) continue;
    const Attempt& chosen = most_significant(tried);
    const double glance = significance(some, chosen.pose, chosen.bound, Scrutiny::glance).log10_false_poses + penalty();
    if (glance < detail::kBeyondDoubt) return {measured_bound(correspondences, chosen), glance, kBounds};
  }
  Attempt chosen{largest_bound, {}, 0.0};
  for (const Effort& effort : {kOnAll, kLast}) {
    const std::vector<Attempt> tried = attempts(correspondences, largest_bound, seed, effort);
    if (tried.empty()) break;
    const Attempt& plain = most_significant(tried);
    const double glance = significance(correspondences, plain.pose, plain.bound, Scrutiny::glance).log10_false_poses;
    if (glance + penalty() < detail::kBeyondDoubt)
      return {measured_bound(correspondences, plain), glance + penalty(), kBounds};
    const Attempt close = looked_at_closely(correspondences, tried);
    if (close.log10_false_poses < chosen.log10_false_poses) chosen = close;
    if (chosen.log10_false_poses + penalty() < detail::kSignificant) break;
  }
  return {chosen.bound, chosen.log10_false_poses + penalty(), kBounds};
}

}  // namespace consimd
