#include <consimd/solvers/significance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "call/option_checks.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/pose_test.hpp"
#include "verdict/supporters.hpp"

namespace consimd {
namespace {

using detail::kTestedBounds;
using detail::Supports;
using detail::supports;

// Supporters closer than this, in noise bounds, count once; where outliers move as one over longer distances, those.
constexpr double kLeastRadius = 1.75;
constexpr double kLargestRadius = 3.0;
// Residuals of near misses: what is closer than that to a supporter tells of the same place, in noise bounds.
constexpr double kNearMisses = 4.0;

// Mismatched pairings of all correspondences, and pairs whose lengths are compared.
constexpr std::uint32_t kShifts = 32;
constexpr std::uint32_t kPairs = 4096;
constexpr std::uint32_t kStratumPairs = 1024;
constexpr std::uint32_t kGlanceShifts = 8;
constexpr std::uint32_t kGlancePairs = 256;
// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;
// Structure that gives so many hits by chance alone, once in so many times, is none.
constexpr double kNoStructure = 1e-3;
// A glance takes structure to give a pose at most so many times the support that random pairing does, and lengths that
// agree so many times as often.
constexpr double kStrongestStructure = 100.0;
constexpr double kStrongestLikeness = 2.0;
// What a sample tells of structure, times this, is more than what all rows do.
constexpr double kSafety = 4.0;
// ln of false poses from which on a first glance is enough.
constexpr double kEnough = detail::kBeyondDoubt * std::numbers::ln10;

// ln P[Binomial(n, p) >= k], k above the mean, by the exponential bound of Chernoff with the factor of Bahadur and Rao.
double log_binomial_tail(double n, double k, double p) {
  if (k <= n * p) return 0.0;
  if (p == 0.0) return -std::numeric_limits<double>::infinity();
  const double share = std::min(k / n, 1.0);
  const double divergence =
      share * std::log(share / p) + (share < 1.0 ? (1.0 - share) * std::log((1.0 - share) / (1.0 - p)) : 0.0);
  const double spread = 2.0 * std::numbers::pi * n * share * (1.0 - share);
  const double ratio = p * (1.0 - share) / (share * (1.0 - p));
  return std::min(0.0, -n * divergence - 0.5 * std::log(std::max(spread, 1.0)) - std::log(1.0 - ratio));
}

// ln of the number of triples of n.
double log_triples(double n) { return std::log(std::max(n * (n - 1.0) * (n - 2.0) / 6.0, 1.0)); }

// Chances at each of the tested bounds.
struct Chances {
  std::array<double, kTestedBounds.size()> support{};  // that a pose takes a source to the target of another row
  std::array<double, kTestedBounds.size()> length{};   // that two correspondences agree in length
};

// ln of the number of false poses that the supporters at the most telling bound leave.
double log_false_poses(double size, const Supports& supports, const Chances& chances) {
  double least = log_triples(size);
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    const auto& [count, spread] = supports[b];
    if (spread < 3.0 || size <= 3.0) continue;
    const double chance = chances.support[b] * spread / count;
    least = std::min(least, log_triples(size) - log_triples(count) + 3.0 * std::log(chances.length[b]) +
                                log_binomial_tail(size - 3.0, spread - 3.0, chance));
  }
  return least + std::log(static_cast<double>(kTestedBounds.size()));
}

// What pairing at random gives. `pairs`: whose lengths are compared; `shifts`: pairings of all correspondences.
Chances random_chances(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, std::uint32_t pairs,
                       std::uint32_t shifts, detail::RareHits rare, const detail::MatchedPoints& matched) {
  const std::vector<std::uint32_t> explained = detail::pose_inliers(view, pose, noise_bound);
  const detail::LengthChance length_chance(view, explained, pairs, kFixedSeed);
  Chances result;
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    const double bound = kTestedBounds[b] * noise_bound;
    result.support[b] = detail::pose_chance(view, pose, bound, shifts, rare, matched);
    result.length[b] = length_chance(2.0 * bound);
  }
  return result;
}

// The chance that hits among trials tell of, or that of random pairing where they do not differ from it.
double structured(double at_random, double hits, double trials) {
  if (log_binomial_tail(trials, hits, at_random) > std::log(kNoStructure)) return at_random;
  return std::max(at_random, detail::chance(hits, trials));
}

// What pairing within strata gives.
Chances kept_chances(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                     const detail::Strata& strata, const detail::MatchedPoints& matched, const Chances& at_random) {
  const detail::PairingHits support = strata.support(view, pose, noise_bound, kNearMisses * noise_bound, matched);
  const detail::PairingHits length = strata.lengths(view, noise_bound, kStratumPairs);
  Chances result;
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    result.support[b] = structured(at_random.support[b], support.hits[b], support.trials);
    result.length[b] = structured(at_random.length[b], length.hits[b], length.trials);
  }
  return result;
}

double plain_look(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  const detail::MatchedPoints matched(view, pose, noise_bound);
  const Chances chances =
      random_chances(view, pose, noise_bound, kStratumPairs, kGlanceShifts, detail::RareHits::extrapolated, matched);
  const Supports found = supports(view, pose, noise_bound, kLeastRadius * noise_bound);
  return log_false_poses(static_cast<double>(view.size()), found, chances);
}

double glance(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  const detail::MatchedPoints matched(view, pose, noise_bound);
  Chances chances =
      random_chances(view, pose, noise_bound, kGlancePairs, kGlanceShifts, detail::RareHits::laplace, matched);
  for (double& chance : chances.support) chance = std::min(1.0, kStrongestStructure * chance);
  for (double& chance : chances.length) chance = std::min(1.0, kStrongestLikeness * chance);
  const Supports found = supports(view, pose, noise_bound, kLargestRadius * noise_bound);
  return log_false_poses(static_cast<double>(view.size()), found, chances);
}

// A second glance, at structure in a sample of the rows.
double second_glance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const detail::MatchedPoints matched(view, pose, noise_bound);
  const auto size = static_cast<double>(view.size());
  const Supports found = supports(view, pose, noise_bound, kLargestRadius * noise_bound);
  Chances chances =
      random_chances(view, pose, noise_bound, kGlancePairs, kGlanceShifts, detail::RareHits::laplace, matched);
  for (double& chance : chances.length) chance = std::min(1.0, kStrongestLikeness * chance);
  for (const detail::Strata& strata : detail::sampled_strata(correspondences)) {
    const detail::PairingHits kept = strata.support(view, pose, noise_bound, kNearMisses * noise_bound, matched);
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      chances.support[b] = std::max(chances.support[b], kSafety * detail::chance(kept.hits[b], kept.trials));
    }
  }
  for (double& chance : chances.support) chance = std::min(1.0, chance);
  return log_false_poses(size, found, chances);
}

double close_look(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const detail::MatchedPoints matched(view, pose, noise_bound);
  const auto size = static_cast<double>(view.size());
  const double radius =
      detail::coherence_length(view, pose, noise_bound, kLeastRadius * noise_bound, kLargestRadius * noise_bound);
  const Supports found = supports(view, pose, noise_bound, radius);
  const Chances at_random =
      random_chances(view, pose, noise_bound, kPairs, kShifts, detail::RareHits::extrapolated, matched);
  double most = log_false_poses(size, found, at_random);
  for (const detail::Strata& strata : detail::kept_strata(correspondences)) {
    const Chances kept = kept_chances(view, pose, noise_bound, strata, matched, at_random);
    most = std::max(most, log_false_poses(size, found, kept));
  }
  return most;
}

}  // namespace

Significance significance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                          Scrutiny scrutiny) {
  detail::require_length("noise_bound", noise_bound);
  if (!correspondences.far_rows().empty()) {
    return significance(correspondences.subset(correspondences.near_rows()), pose, noise_bound, scrutiny);
  }
  const CorrespondenceView view = correspondences.view();
  if (view.size() < 3) return {};
  if (scrutiny == Scrutiny::plain) return {plain_look(view, pose, noise_bound) / std::numbers::ln10};
  if (scrutiny == Scrutiny::close) return {close_look(correspondences, pose, noise_bound) / std::numbers::ln10};
  double false_poses = glance(view, pose, noise_bound);
  if (false_poses > kEnough) false_poses = std::min(false_poses, second_glance(correspondences, pose, noise_bound));
  return {false_poses / std::numbers::ln10};
}

}  // namespace consimd
