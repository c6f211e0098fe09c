#include "verdict/background.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "support/repeated_points.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/kept_structure.hpp"
#include "verdict/pairing_chances.hpp"

namespace consimd::detail {
namespace {

// Mismatched pairings of all correspondences, and pairs whose lengths are compared.
constexpr std::uint32_t kShifts = 32;
constexpr std::uint32_t kPairs = 4096;
constexpr std::uint32_t kStratumPairs = 1024;
// Structure that gives so many hits by chance alone, once in so many times, is none.
constexpr double kNoStructure = 1e-3;

// The chance that hits among trials tell of, or that of random pairing where they do not differ from it.
double structured(double at_random, double hits, double trials) {
  if (log_binomial_tail(trials, hits, at_random) > std::log(kNoStructure)) return at_random;
  return std::max(at_random, chance(hits, trials));
}

}  // namespace

Background::Background(const Correspondences& correspondences, double noise_bound)
    : view_(correspondences.view()), noise_bound_(noise_bound), coherence_(view_, noise_bound) {
  for (Strata& strata : kept_strata(correspondences, kNearMisses * noise_bound)) {
    const PairingHits lengths = strata.lengths(noise_bound, kStratumPairs);
    kept_.push_back({std::move(strata), lengths});
  }
}

double Background::log_false_poses(const WorkingPose& pose) const {
  const auto size = static_cast<double>(view_.size());
  const double radius = coherence_.length(pose, kLeastRadius, kLargestRadius) * noise_bound_;
  const Supports found = supports(view_, pose, noise_bound_, radius);
  const MatchedPoints matched(view_, pose, noise_bound_);
  const Chances at_random = random_chances(view_, pose, noise_bound_, kPairs, kShifts, RareHits::extrapolated, matched);
  double most = detail::log_false_poses(size, found, at_random);
  for (const auto& [strata, length] : kept_) {
    const PairingHits support = strata.support(pose, noise_bound_, matched);
    Chances chances;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      chances.support[b] = structured(at_random.support[b], support.hits[b], support.trials);
      chances.length[b] = structured(at_random.length[b], length.hits[b], length.trials);
    }
    most = std::max(most, detail::log_false_poses(size, found, chances));
  }
  return most;
}

}  // namespace consimd::detail
