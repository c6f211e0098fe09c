#include <consimd/solvers/noise_bound.hpp>

#include <algorithm>
#include <array>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include <consimd/solvers/significance.hpp>

#include "call/distinct_rows.hpp"
#include "call/option_checks.hpp"
#include "noise_bound/bound_attempts.hpp"
#include "noise_bound/bound_search.hpp"
#include "noise_bound/measured_bound.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

// A pose that a fiftieth of the rows supports is met by the seeds in a sample of the rows.
constexpr std::size_t kSampledRows = 1024;
constexpr std::size_t kSampleGrowth = 4;
// A plain look has so much from its few samples: a close one may find less than it by this, in log10 of false poses.
constexpr double kPlainError = 1.0;
// Close looks past a significant attempt.
constexpr std::uint32_t kLooksPast = 3;
// Attempts that are looked at between the bounds as well, and where.
constexpr std::size_t kFinerOfFew = 3;
constexpr std::array kFinerFactors{std::numbers::sqrt2 / 2.0, std::numbers::sqrt2};

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
  const double largest_bound = largest_bound_of(correspondences);
  if (!(largest_bound > 0.0)) return {{1.0, 0.0, 1}, {}};
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
