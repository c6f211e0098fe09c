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
#include "call/option_checks.hpp"
#include "noise_bound/bound_attempts.hpp"
#include "noise_bound/bound_search.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

// Sources further from their centroid than this, in median distances, say nothing of the extent.
constexpr float kBulk = 32.0F;
constexpr double kLargestBound = 1.0 / 4.0;  // of the extent
// Points closer than this share of their distance from the origin differ by rounding.
constexpr double kResolution = 1e-14;
// A pose that a fiftieth of the rows supports is met by the seeds in a sample of the rows.
constexpr std::size_t kSampledRows = 1024;
constexpr std::size_t kSampleGrowth = 4;
// The bound is three deviations; measured again until it changes by less than this factor.
constexpr double kDeviations = 3.0;
constexpr double kSettledFactor = 1.05;
constexpr int kMeasurements = 20;
// A plain look has so much from its few samples: a close one may find less than it by this, in log10 of false poses.
constexpr double kPlainError = 1.0;
// Close looks past a significant attempt.
constexpr std::uint32_t kLooksPast = 3;
// Attempts that are looked at between the bounds as well, and where.
constexpr std::size_t kFinerOfFew = 3;
constexpr std::array kFinerFactors{std::numbers::sqrt2 / 2.0, std::numbers::sqrt2};

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

bool are_alike(double bound, double other) { return bound < other * kSettledFactor && other < bound * kSettledFactor; }

// Three times the scale of the residuals around the pose, from the bound that it was found with, and the pose that is
// most likely with it.
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

// The measured bound. Where the pose is significant with that of the attempt and is not with what is measured, of what
// lies between the first that will do.
double measured_bound(const Correspondences& correspondences, CloseLooks& looks, const Attempt& attempt) {
  const Attempt at_noise = measured(correspondences, attempt);
  const WorkingPose& pose = at_noise.pose;
  double bound = at_noise.bound;
  if (looks.is_significant(pose, bound) || !looks.is_significant(attempt.pose, attempt.bound)) {
    return bound;
  }
  // The pose of the attempt is the better one where few rows make the weights of a fit extreme.
  while (bound < attempt.bound && !looks.is_significant(pose, bound) && !looks.is_significant(attempt.pose, bound)) {
    bound *= kFinerFactors.back();
  }
  return std::min(bound, attempt.bound);
}

// The pose of an attempt at another bound, held against random pairing alone.
Attempt brought_to(const Correspondences& correspondences, const Attempt& attempt, double bound) {
  const PoseCandidate start = scored(correspondences.view(), attempt.pose, bound);
  const PoseCandidate best = widely_optimise(correspondences, start, bound);
  return {bound, best.pose, significance(correspondences, best.pose, bound, Scrutiny::plain).log10_false_poses};
}

// Attempts that are looked at closely, the most significant one first, of equal ones that at the larger bound.
// Structure makes no pose more significant, so that most attempts among many rows are out of the question without a
// close look if they are to be more so than `least`; among few a plain look is no better than its samples.
std::vector<Attempt> looked_at(CloseLooks& looks, std::vector<Attempt> tried, double least) {
  std::ranges::stable_sort(tried, {}, &Attempt::log10_false_poses);
  const bool few = looks.are_cheap();
  std::uint32_t since_least = 0;
  std::size_t looked = 0;
  for (; looked < tried.size(); ++looked) {
    Attempt& attempt = tried[looked];
    const double possible = attempt.log10_false_poses - kPlainError;
    const bool is_enough = possible >= std::min(least, kSignificant - penalty()) ||
                           (since_least == kLooksPast && least + penalty() < kSignificant);
    if (is_enough && !few) break;
    attempt.log10_false_poses = looks.log10_false_poses(attempt.pose, attempt.bound, few ? 0.0 : least);
    since_least = attempt.log10_false_poses < least ? 0 : since_least + 1;
    least = std::min(least, attempt.log10_false_poses);
  }
  tried.resize(looked);
  std::ranges::stable_sort(tried, {}, [](const Attempt& a) { return std::pair(a.log10_false_poses, -a.bound); });
  return tried;
}

// The attempts brought into place, and between their bounds. Two attempts at a bound and its half are alike between
// these: of those the one stays that random pairing gives less often.
std::vector<Attempt> with_finer_bounds(const Correspondences& correspondences, const std::vector<Attempt>& tried) {
  std::vector<Attempt> result;
  result.reserve((1 + kFinerFactors.size()) * tried.size());
  for (const Attempt& attempt : tried) result.push_back(brought_to(correspondences, attempt, attempt.bound));
  const std::size_t coarse = result.size();
  for (std::size_t k = 0; k < coarse; ++k) {
    for (const double factor : kFinerFactors) {
      const Attempt finer = brought_to(correspondences, result[k], factor * result[k].bound);
      const auto beside = std::find_if(result.begin() + static_cast<std::ptrdiff_t>(coarse), result.end(),
                                       [&](const Attempt& other) { return are_alike(other.bound, finer.bound); });
      if (beside == result.end()) {
        result.push_back(finer);
      } else if (finer.log10_false_poses < beside->log10_false_poses) {
        *beside = {beside->bound, finer.pose, finer.log10_false_poses};
      }
    }
  }
  return result;
}

// The most significant of `best`, of what was tried, and of what lies between.
Attempt looked_at_closely(const Correspondences& correspondences, CloseLooks& looks, std::vector<Attempt> tried,
                          const Attempt& best) {
  const bool few = looks.are_cheap();
  const double needed = kSignificant + (few ? 0.0 : kPlainError - penalty());
  const auto has_a_chance = [&](const Attempt& attempt) { return attempt.log10_false_poses < needed; };
  std::vector<Attempt> offered{best};
  const auto settled = [&] {
    const Attempt& least = *std::ranges::min_element(offered, {}, rank);
    return least.log10_false_poses < best.log10_false_poses ? least : best;
  };
  if (std::ranges::none_of(tried, has_a_chance)) {
    offered.insert(offered.end(), tried.begin(), tried.end());
    return settled();
  }
  std::erase_if(tried, std::not_fn(has_a_chance));
  if (few) {
    for (Attempt& attempt : tried) attempt = brought_to(correspondences, attempt, attempt.bound);
  } else {
    tried = with_finer_bounds(correspondences, tried);
  }
  std::vector<Attempt> looked = looked_at(looks, std::move(tried), best.log10_false_poses);
  offered.insert(offered.end(), looked.begin(), looked.end());
  const Attempt first = settled();
  if (!few && first.log10_false_poses >= best.log10_false_poses) return best;
  looked.resize(std::min(looked.size(), few ? kFinerOfFew : 1));
  std::vector<Attempt> finer;
  for (const Attempt& attempt : looked) {
    for (const double factor : kFinerFactors) {
      if (few) finer.push_back(brought_to(correspondences, attempt, factor * attempt.bound));
    }
    finer.push_back(brought_to(correspondences, attempt, measured_bound(correspondences, looks, attempt)));
    if (!few && are_alike(finer.back().bound, attempt.bound)) finer.pop_back();
  }
  finer = looked_at(looks, std::move(finer), first.log10_false_poses);
  offered.insert(offered.end(), finer.begin(), finer.end());
  return settled();
}

// Every so many rows, as many as wanted; all where these are not as many.
Correspondences sample(const Correspondences& correspondences, std::size_t wanted) {
  const std::size_t size = correspondences.size();
  std::vector<std::uint32_t> rows(std::min(size, wanted));
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<std::uint32_t>(k * size / rows.size());
  return correspondences.subset(rows);
}

}  // namespace

BoundSearch search_noise_bound(const Correspondences& all, std::uint64_t seed, const StopCondition& stop) {
  require_usable_unit(all);
  const DistinctRows rows(all);
  const Correspondences& correspondences = rows.correspondences();
  const double size = extent(correspondences);
  const auto& centroid = correspondences.source_centroid();
  if (!(size > kResolution * Eigen::Map<const Eigen::Vector3d>(centroid.data()).stableNorm()))
    return {{1.0, 0.0, 1}, {}};
  const double largest_bound = kLargestBound * size;
  CloseLooks looks(correspondences);
  const auto from = [&](const Attempt& sure) {
    const double bound = measured_bound(correspondences, looks, sure);
    std::vector<WorkingPose> poses;
    if (stop.met()) poses.push_back(sure.pose);
    return BoundSearch{{bound, sure.log10_false_poses, kBounds}, std::move(poses)};
  };
  // A pose that some of the rows put beyond doubt tells the noise as well as all of them do.
  for (std::size_t wanted = kSampledRows; 2 * wanted < correspondences.size(); wanted *= kSampleGrowth) {
    const Correspondences some = sample(correspondences, wanted);
    const BoundAttempts found(some, largest_bound, seed, kOnSample, stop);
    if (found.beyond_doubt()) return from(*found.beyond_doubt());
  }
  Attempt chosen{largest_bound, {}, 0.0};
  std::vector<WorkingPose> poses;
  for (const Effort& effort : efforts(correspondences.size())) {
    const BoundAttempts found(correspondences, largest_bound, seed, effort, stop);
    if (found.beyond_doubt()) return from(*found.beyond_doubt());
    for (const Attempt& attempt : found.tried()) poses.push_back(attempt.pose);
    chosen = looked_at_closely(correspondences, looks, found.tried(), chosen);
    if (chosen.log10_false_poses + penalty() < kSignificant || stop.met()) break;
  }
  const NoiseBoundEstimate estimate{chosen.bound, chosen.log10_false_poses + penalty(), kBounds};
  if (estimate.log10_false_poses >= kSignificant) return {estimate, {}};
  poses.insert(poses.begin(), chosen.pose);
  return {estimate, std::move(poses)};
}

bool is_chance_at_its_noise(const Correspondences& all, const RigidTransform& T_target_source, double noise_bound) {
  const DistinctRows rows(all);
  const Correspondences& correspondences = rows.correspondences();
  const Attempt at_noise =
      measured(correspondences, {noise_bound, to_working_pose(to_working_frame(T_target_source, correspondences))});
  if (are_alike(at_noise.bound, noise_bound) || glance(correspondences, at_noise) < kBeyondDoubt) return false;
  return CloseLooks(correspondences).log10_false_poses(at_noise.pose, at_noise.bound) >= 0.0;
}

}  // namespace consimd::detail

namespace consimd {

NoiseBoundEstimate estimate_noise_bound(const Correspondences& correspondences, std::uint64_t seed) {
  return detail::search_noise_bound(correspondences, seed).estimate;
}

}  // namespace consimd
