#include <consimd/solvers/significance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "call/option_checks.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"
#include "support/row_blocks.hpp"
#include "verdict/pairing_chances.hpp"

namespace consimd {
namespace {

constexpr std::array kBounds{1.0, 0.5, 0.7, 0.35};  // in noise bounds
// ln of false poses at which no other bound is tried, and at which a glance is enough.
constexpr double kLnNoOtherBoundTried = -20.0;
constexpr double kLnGlanceSuffices = -10.4;

// How closely is looked: a glance settles most cases.
struct Effort {
  std::size_t bounds;      // of kBounds
  std::size_t supporters;  // that are told apart
  std::uint32_t pairs;     // whose lengths are compared
  std::uint32_t shifts;    // mismatched pairings of all correspondences
};
constexpr Effort kGlance{2, 64, 256, 8};
constexpr Effort kClose{kBounds.size(), 192, 1024, 32};

// Supporters closer than this may be one cluster of sources that matches one of targets, in bounds.
constexpr double kClusterRadius = 1.75;

// Supporters whose sources are further apart than a radius.
struct Independent {
  double count = 0.0;
  double share = 1.0;   // of the supporters looked at
  double looked = 1.0;  // share of the supporters that were
};

Independent independent_supporters(const CorrespondenceView& view, std::span<const std::uint32_t> supporters,
                                   double radius, std::size_t most) {
  if (supporters.empty()) return {};
  const double limit = radius * view.scale() * radius * view.scale();
  const std::size_t looked = std::min(supporters.size(), most);
  std::vector<detail::Point> kept;
  kept.reserve(looked);
  for (std::size_t s = 0; s < looked; ++s) {
    const detail::Point p = detail::source_point(view, supporters[s * supporters.size() / looked]);
    const bool repeats =
        std::ranges::any_of(kept, [&](const detail::Point& q) { return squared_distance(p, q) < limit; });
    if (!repeats) kept.push_back(p);
  }
  const auto count = static_cast<double>(kept.size());
  return {count, count / static_cast<double>(looked),
          static_cast<double>(looked) / static_cast<double>(supporters.size())};
}

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

// ln of the number of triples of n, which need not be whole.
double log_triples(double n) { return std::log(std::max(n * (n - 1.0) * (n - 2.0) / 6.0, 1.0)); }

// Chance of support that the correspondences just outside the bound tell of: their number in the shell from one to two
// bounds over its volume in balls of one.
double near_miss_chance(const CorrespondenceView& view, const WorkingPose& pose, double bound, std::size_t supporters) {
  const double within_two = detail::row_blocks::alignment_count(view, pose, 2.0 * bound);
  const double shell = within_two - static_cast<double>(supporters);
  return (shell + 1.0) / (7.0 * static_cast<double>(view.size()));
}

// ln of the number of false poses that `supporters` leave.
double log_false_poses(double size, const Independent& supporters, double length_chance, double supporter_chance) {
  const double trials = supporters.looked * size - 3.0;
  const double tail = trials > 0.0 ? log_binomial_tail(trials, supporters.count - 3.0, supporter_chance) : 0.0;
  return log_triples(size) - log_triples(supporters.count) + 3.0 * std::log(length_chance) + tail;
}

// ln of the number of false poses, at the most telling bound.
double least_log_false_poses(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                             std::span<const std::uint32_t> explained, std::uint64_t seed, const Effort& effort) {
  const auto size = static_cast<double>(view.size());
  const detail::LengthChance length_chance(view, explained, effort.pairs, seed);
  double least = log_triples(size);
  for (const double share : std::span(kBounds).first(effort.bounds)) {
    const double bound = share * noise_bound;
    const std::vector<std::uint32_t> rows =
        share == 1.0 ? std::vector(explained.begin(), explained.end()) : detail::pose_inliers(view, pose, bound);
    const Independent supporters = independent_supporters(view, rows, kClusterRadius * bound, effort.supporters);
    if (supporters.count < 3.0) continue;
    const double by_any = detail::pose_chance(view, pose, bound, effort.shifts);
    const double by_neighbour = supporters.share * near_miss_chance(view, pose, bound, rows.size());
    least =
        std::min(least, log_false_poses(size, supporters, length_chance(2.0 * bound), std::max(by_any, by_neighbour)));
    if (least < kLnNoOtherBoundTried) break;
  }
  return least;
}

}  // namespace

Significance significance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                          std::uint64_t seed, Scrutiny scrutiny) {
  detail::require_length("noise_bound", noise_bound);
  const CorrespondenceView view = correspondences.view();
  Significance result;
  if (view.size() < 3) return result;
  const std::vector<std::uint32_t> explained = detail::pose_inliers(view, pose, noise_bound);
  double least = least_log_false_poses(view, pose, noise_bound, explained, seed, kGlance);
  if (least > kLnGlanceSuffices && scrutiny == Scrutiny::close) {
    least = least_log_false_poses(view, pose, noise_bound, explained, seed, kClose);
  }
  result.independent_share = independent_supporters(view, explained, noise_bound, kGlance.supporters).share;
  result.log10_false_poses = (least + std::log(static_cast<double>(kBounds.size()))) / std::numbers::ln10;
  return result;
}

}  // namespace consimd
