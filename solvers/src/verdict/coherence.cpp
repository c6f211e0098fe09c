#include "verdict/coherence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sampling/counter_random.hpp"
#include "support/point_cells.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

// Steps of the distance in noise bounds, the lift over chance from which correspondences move as one, and how many
// pairs a step needs.
constexpr double kStep = 0.5;
constexpr double kCoherentLift = 2.5;
constexpr double kLeastPairs = 20.0;
// Rows whose neighbours are looked at, and pairs that are enough.
constexpr std::uint32_t kLookedAt = 256;
constexpr std::size_t kEnoughPairs = 1U << 17U;
constexpr std::uint32_t kRandomPairs = 8192;
// Lengths that differ by less, in noise bounds, agree.
constexpr double kAgreeing = 2.0;
// A row within so many noise bounds of its target is explained.
constexpr double kExplained = 2.0;
// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

double middle_of(std::size_t step) { return (static_cast<double>(step) + 0.5) * kStep; }

}  // namespace

Coherence::Coherence(const CorrespondenceView& view, double noise_bound) : view_(view), noise_bound_(noise_bound) {
  const double unit = noise_bound * view.scale();
  const auto size = static_cast<std::uint32_t>(view.size());
  const double reach = static_cast<double>(kSteps) * kStep * unit;
  const auto limit = static_cast<float>(reach * reach);
  const PointCells sources(size, reach, [&](std::uint32_t row) { return source_point(view, row); });
  const std::uint32_t looked_at = std::min(kLookedAt, size);
  for (std::uint32_t l = 0; l < looked_at && pairs_.size() < kEnoughPairs; ++l) {
    // Rows spread by the golden ratio: however few are looked at, they are from all over.
    const auto row = static_cast<std::uint32_t>(((l * 0x9E3779B97F4A7C15U) >> 32U) * size >> 32U);
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    if (std::isnan(p.x)) continue;  // a far row
    sources.visit(p, limit, [&](std::uint32_t other, float squared) {
      if (squared == 0.0F) return;
      const double apart = std::sqrt(static_cast<double>(squared)) / unit;
      const auto step = std::min(static_cast<std::size_t>(apart / kStep), kSteps - 1);
      const bool agrees = std::abs(distance(q, target_point(view, other)) / unit - apart) < kAgreeing;
      pairs_.push_back({row, other, static_cast<std::uint8_t>(step), agrees});
    });
  }
  for (std::uint32_t k = 0; k < kRandomPairs && size > 0; ++k) {
    CounterRandom random(kFixedSeed, RandomStage::pairing, k);
    const double apart =
        distance(target_point(view, random.below(size)), target_point(view, random.below(size))) / unit;
    for (std::size_t step = 0; step < kSteps; ++step) {
      if (std::abs(apart - middle_of(step)) < kAgreeing) ++by_chance_[step];
    }
  }
  for (double& share : by_chance_) share = (share + 1.0) / (kRandomPairs + 2.0);
}

double Coherence::length(const WorkingPose& pose, double least, double most) const {
  std::vector<bool> explained(view_.size());
  for (const std::uint32_t row : pose_inliers(view_, pose, kExplained * noise_bound_)) explained[row] = true;
  std::array<double, kSteps> agreeing{};
  std::array<double, kSteps> pairs{};
  for (const Pair& pair : pairs_) {
    if (explained[pair.row] || explained[pair.other]) continue;
    ++pairs[pair.step];
    agreeing[pair.step] += pair.agrees ? 1.0 : 0.0;
  }
  // Where the lift falls below the limit, between the middles of two steps.
  double length = least;
  double former = std::numeric_limits<double>::infinity();
  for (auto step = static_cast<std::size_t>(length / kStep) - 1; step < kSteps; ++step) {
    if (pairs[step] < kLeastPairs) break;
    const double lift = agreeing[step] / (by_chance_[step] * pairs[step]);
    if (lift < kCoherentLift) {
      if (std::isfinite(former)) length = middle_of(step) - kStep * (kCoherentLift - lift) / (former - lift);
      break;
    }
    length = middle_of(step);
    former = lift;
  }
  return std::clamp(length, least, most);
}

}  // namespace consimd::detail
