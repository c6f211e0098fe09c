#include "verdict/false_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

// ln of the number of triples of n.
double log_triples(double n) { return elementary::log(std::max(n * (n - 1.0) * (n - 2.0) / 6.0, 1.0)); }

}  // namespace

double log_binomial_tail(double n, double k, double p) {
  if (k <= n * p) return 0.0;
  if (p == 0.0) return -std::numeric_limits<double>::infinity();
  const double share = std::min(k / n, 1.0);
  const double divergence = share * elementary::log(share / p) +
                            (share < 1.0 ? (1.0 - share) * elementary::log((1.0 - share) / (1.0 - p)) : 0.0);
  const double spread = 2.0 * std::numbers::pi * n * share * (1.0 - share);
  const double ratio = p * (1.0 - share) / (share * (1.0 - p));
  return std::min(0.0, -n * divergence - 0.5 * elementary::log(std::max(spread, 1.0)) - elementary::log(1.0 - ratio));
}

double fit_gain(const Supports& supports) {
  // Three rows leave no residuals; from four on the ratio is a number.
  const double count = std::max(supports.front().count, 4.0);
  return std::sqrt((count + 2.0) / (count - 2.0));
}

double log_false_poses(double size, const Supports& supports, const Chances& chances) {
  double least = log_triples(size);
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    const auto& [count, spread] = supports[b];
    if (spread < 3.0 || size <= 3.0) continue;
    const double chance = chances.support[b] * spread / count;
    least = std::min(least, log_triples(size) - log_triples(count) + 3.0 * elementary::log(chances.length[b]) +
                                log_binomial_tail(size - 3.0, spread - 3.0, chance));
  }
  return least + elementary::log(static_cast<double>(kTestedBounds.size()));
}

double independent_support(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  return supports(view, pose, noise_bound, kLargestRadius * noise_bound).front().spread;
}

Chances random_chances(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double reach,
                       std::uint32_t pairs, std::uint32_t shifts, RareHits rare, const MatchedPoints& matched) {
  const std::vector<std::uint32_t> explained = pose_inliers(view, pose, noise_bound);
  const LengthChance length_chance(view, explained, pairs, kFixedSeed);
  Chances result;
  std::array<double, kTestedBounds.size()> reaches{};
  std::ranges::transform(kTestedBounds, reaches.begin(), [reach](double tested) { return tested * reach; });
  std::ranges::copy(pose_chances(view, pose, reaches, shifts, rare, matched), result.support.begin());
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    result.length[b] = length_chance(2.0 * kTestedBounds[b] * noise_bound);
  }
  return result;
}

}  // namespace consimd::detail
