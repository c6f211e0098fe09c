#include <consimd/solvers/significance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>

#include "counter_random.hpp"
#include "option_checks.hpp"
#include "sampling.hpp"
#include "set_poses.hpp"

namespace consimd {
namespace {

constexpr std::array kBounds{1.0, 0.7, 0.5, 0.35};  // in noise bounds
constexpr std::uint32_t kShifts = 32;               // mismatched pairings of all correspondences
constexpr std::uint32_t kLengthSamples = 1024;
constexpr std::size_t kSmall = 8 * kBlock;  // up to here correspondences are shifted row by row
constexpr std::size_t kLooked = 64;         // supporters whose neighbours are looked at

struct Point {
  float x, y, z;
};

Point source(const CorrespondenceView& view, std::size_t k) {
  return {view.source(0)[k], view.source(1)[k], view.source(2)[k]};
}
Point target(const CorrespondenceView& view, std::size_t k) {
  return {view.target(0)[k], view.target(1)[k], view.target(2)[k]};
}

double distance(const Point& a, const Point& b) {
  const double x = a.x - b.x;
  const double y = a.y - b.y;
  const double z = a.z - b.z;
  return std::sqrt(x * x + y * y + z * z);
}

Point moved(const WorkingPose& pose, const Point& p) {
  const float* r = pose.rotation;
  const float* t = pose.translation;
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
          r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
}

// Laplace's estimate of a chance that gave `hits` in `trials`.
double chance(double hits, double trials) { return (hits + 1.0) / (trials + 2.0); }

// Chance that the pose takes a source within `bound` of the target of any other correspondence.
double pose_chance(const CorrespondenceView& view, const WorkingPose& pose, double bound) {
  const std::size_t size = view.size();
  double hits = 0.0;
  double trials = 0.0;
  if (size <= kSmall) {
    const double limit = bound * view.scale();
    const std::size_t step = std::max<std::size_t>(1, (size - 1) / kShifts);
    for (std::size_t shift = 1; shift < size; shift += step) {
      for (std::size_t i = 0; i < size; ++i) {
        hits += distance(moved(pose, source(view, i)), target(view, (i + shift) % size)) < limit ? 1.0 : 0.0;
      }
      trials += static_cast<double>(size);
    }
    return chance(hits, trials);
  }
  const auto blocks = static_cast<std::uint32_t>((size - 1) / kBlock);
  const std::uint32_t used = std::min(kShifts, blocks);
  std::vector<std::uint32_t> shifts(used);
  std::vector<std::uint32_t> counts(used);
  for (std::uint32_t s = 0; s < used; ++s) shifts[s] = 1 + s * blocks / used;
  mismatched_counts(view, pose, bound, shifts, counts);
  for (std::uint32_t s = 0; s < used; ++s) {
    hits += counts[s];
    trials += static_cast<double>(mismatched_pairs(view, shifts[s]));
  }
  return chance(hits, trials);
}

// Share of `supporters` whose source is further than the bound from that of the supporters before it in the order of
// one axis. Estimated from a sample.
double independent_share(const CorrespondenceView& view, std::vector<std::uint32_t> supporters, double bound) {
  const float* x = view.source(0);
  std::sort(supporters.begin(), supporters.end(), [x](std::uint32_t a, std::uint32_t b) { return x[a] < x[b]; });
  const double limit = bound * view.scale();
  const std::size_t step = std::max<std::size_t>(1, supporters.size() / kLooked);
  std::size_t looked = 0;
  std::size_t kept = 0;
  for (std::size_t s = 0; s < supporters.size(); s += step) {
    const Point p = source(view, supporters[s]);
    bool repeats = false;
    for (std::size_t before = s; before-- > 0 && !repeats && p.x - x[supporters[before]] < limit;) {
      repeats = distance(p, source(view, supporters[before])) < limit;
    }
    ++looked;
    kept += repeats ? 0 : 1;
  }
  return looked > 0 ? static_cast<double>(kept) / static_cast<double>(looked) : 1.0;
}

// Differences between the lengths of random source pairs and random other target pairs, working frame.
std::vector<double> length_differences(const CorrespondenceView& view, std::uint64_t seed) {
  const auto size = static_cast<std::uint32_t>(view.size());
  std::vector<double> differences;
  differences.reserve(kLengthSamples);
  for (std::uint32_t s = 0; s < kLengthSamples; ++s) {
    detail::CounterRandom random(seed, detail::RandomStage::background, s);
    const IndexPair from = detail::draw_pair(random, size);
    const IndexPair to = detail::draw_pair(random, size);
    if (from.first == to.first || from.second == to.second) continue;
    differences.push_back(std::abs(distance(source(view, from.first), source(view, from.second)) -
                                   distance(target(view, to.first), target(view, to.second))));
  }
  return differences;
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

}  // namespace

Significance significance(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                          std::uint64_t seed) {
  detail::require_length("noise_bound", noise_bound);
  const CorrespondenceView view = correspondences.view();
  const auto size = static_cast<double>(view.size());
  Significance result;
  if (size < 3.0) return result;
  const std::vector<double> differences = length_differences(view, seed);
  double least = log_triples(size);
  for (const double share : kBounds) {
    const double bound = share * noise_bound;
    const std::vector<std::uint32_t> rows = detail::pose_inliers(view, pose, bound);
    const double independent = independent_share(view, rows, bound);
    if (share == kBounds.front()) result.independent_share = independent;
    const double supporters = independent * static_cast<double>(rows.size());
    if (supporters < 3.0) continue;
    const auto consistent = std::count_if(differences.begin(), differences.end(),
                                          [&](double difference) { return difference < 2.0 * bound * view.scale(); });
    const double length_chance = chance(static_cast<double>(consistent), static_cast<double>(differences.size()));
    const double tail =
        size > 3.0 ? log_binomial_tail(size - 3.0, supporters - 3.0, pose_chance(view, pose, bound)) : 0.0;
    least = std::min(least, log_triples(size) - log_triples(supporters) + 3.0 * std::log(length_chance) + tail);
  }
  result.log10_false_poses = (least + std::log(static_cast<double>(kBounds.size()))) / std::numbers::ln10;
  return result;
}

}  // namespace consimd
