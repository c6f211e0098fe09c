#include <consimd/solvers/significance.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>

#include "counter_random.hpp"
#include "option_checks.hpp"
#include "sampling.hpp"

namespace consimd {
namespace {

constexpr std::array kBounds{1.0, 0.7, 0.5, 0.35};  // in noise bounds
constexpr std::uint32_t kShifts = 32;               // mismatched pairings of all correspondences
constexpr std::uint32_t kLengthSamples = 1024;
constexpr std::size_t kSmall = 8 * kBlock;  // fewer correspondences are shifted row by row

struct Point {
  float x, y, z;
};

Point source(const CorrespondenceView& view, std::size_t k) {
  return {view.source(0)[k], view.source(1)[k], view.source(2)[k]};
}
Point target(const CorrespondenceView& view, std::size_t k) {
  return {view.target(0)[k], view.target(1)[k], view.target(2)[k]};
}

double distance(const Point& a, const Point& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

Point moved(const WorkingPose& pose, const Point& p) {
  const float* r = pose.rotation;
  const float* t = pose.translation;
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z + t[0], r[3] * p.x + r[4] * p.y + r[5] * p.z + t[1],
          r[6] * p.x + r[7] * p.y + r[8] * p.z + t[2]};
}

// Laplace's estimate of a chance that gave `hits` in `trials`.
double chance(double hits, double trials) { return (hits + 1.0) / (trials + 2.0); }

// How many mismatched pairs fall within a bound of the pose, shift by shift.
struct ShiftedSupport {
  double hits = 0.0;
  double squares = 0.0;
  double trials = 0.0;
  double shifts = 0.0;

  void add(double count, double pairs) {
    hits += count;
    squares += count * count;
    trials += pairs;
    shifts += 1.0;
  }
  // Variance over mean of the counts: 1 for independent correspondences.
  [[nodiscard]] double dispersion() const {
    if (hits == 0.0 || shifts < 2.0) return 1.0;
    const double mean = hits / shifts;
    return std::max(1.0, (squares - hits * mean) / (shifts - 1.0) / mean);
  }
};

ShiftedSupport shifted_support(const CorrespondenceView& view, const WorkingPose& pose, double bound) {
  ShiftedSupport support;
  const std::size_t size = view.size();
  if (size <= kSmall) {
    const double limit = bound * view.scale();
    const std::size_t step = std::max<std::size_t>(1, (size - 1) / kShifts);
    for (std::size_t shift = 1; shift < size; shift += step) {
      std::size_t count = 0;
      for (std::size_t i = 0; i < size; ++i) {
        if (distance(moved(pose, source(view, i)), target(view, (i + shift) % size)) < limit) ++count;
      }
      support.add(static_cast<double>(count), static_cast<double>(size));
    }
    return support;
  }
  const auto blocks = static_cast<std::uint32_t>((size - 1) / kBlock);
  const std::uint32_t used = std::min(kShifts, blocks);
  std::vector<std::uint32_t> shifts(used);
  std::vector<std::uint32_t> counts(used);
  for (std::uint32_t s = 0; s < used; ++s) shifts[s] = 1 + s * blocks / used;
  mismatched_counts(view, pose, bound, shifts, counts);
  for (std::uint32_t s = 0; s < used; ++s) {
    support.add(counts[s], static_cast<double>(mismatched_pairs(view, shifts[s])));
  }
  return support;
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
  const double share = std::min(k / n, 1.0);
  const double divergence =
      share * std::log(share / p) + (share < 1.0 ? (1.0 - share) * std::log((1.0 - share) / (1.0 - p)) : 0.0);
  const double spread = 2.0 * std::numbers::pi * n * share * (1.0 - share);
  const double ratio = p * (1.0 - share) / (share * (1.0 - p));
  return std::min(0.0, -n * divergence - 0.5 * std::log(std::max(spread, 1.0)) - std::log(1.0 - ratio));
}

// ln of the number of triples of n; n need not be whole.
double log_triples(double n) { return std::log(std::max(n * (n - 1.0) * (n - 2.0) / 6.0, 1.0)); }

}  // namespace

double log10_false_poses(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                         std::uint64_t seed) {
  detail::require_length("noise_bound", noise_bound);
  const CorrespondenceView view = correspondences.view();
  const auto size = static_cast<double>(view.size());
  if (size < 3.0) return 0.0;
  const std::vector<double> differences = length_differences(view, seed);
  double least = log_triples(size);
  for (const double share : kBounds) {
    const double bound = share * noise_bound;
    std::uint32_t count = 0;
    alignment_counts(view, std::span(&pose, 1), bound, std::span(&count, 1));
    const ShiftedSupport background = shifted_support(view, pose, bound);
    const double dispersion = background.dispersion();
    if (count < 3 || count / dispersion < 3.0) continue;

    const auto consistent = std::count_if(differences.begin(), differences.end(),
                                          [&](double difference) { return difference < 2.0 * bound * view.scale(); });
    const double poses =
        log_triples(size) - log_triples(count / dispersion) +
        3.0 * std::log(chance(static_cast<double>(consistent), static_cast<double>(differences.size())));
    const double tail = size > 3.0 ? log_binomial_tail((size - 3.0) / dispersion, (count - 3.0) / dispersion,
                                                       chance(background.hits, background.trials))
                                   : 0.0;
    least = std::min(least, poses + tail);
  }
  return (least + std::log(static_cast<double>(kBounds.size()))) / std::numbers::ln10;
}

}  // namespace consimd
