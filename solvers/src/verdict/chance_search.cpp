#include "verdict/chance_search.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "sampling/counter_random.hpp"
#include "verdict/clustering.hpp"

namespace consimd::detail {
namespace {

// Pairings are searched in waves, the later ones only if the first leave doubt.
constexpr std::uint32_t kPairings = 6;
constexpr std::uint32_t kWave = 3;
constexpr std::uint32_t kSeedsPerPairing = 96;
// Least scale of the scores' exponential tail, in supporters: so few pairings tell their own only roughly.
constexpr double kLeastTail = 0.35;
// log10 of false poses beyond which a first wave is believed.
constexpr double kLog10MarginOfDecision = 1.0;

// Fewer correspondences have scores in steps too coarse for a tail, and few triples for the closed form to count.
constexpr std::size_t kLeastRowsForPairings = 128;

// Score of a pairing without any pose. Three supporters are not much more than none.
constexpr double kLeastScore = 2.0;

// Share of clustered correspondences from which random pairings are no match for them.
constexpr double kClusteredShareWithoutPairings = 0.25;

// Permutations of `size` rows, each a shuffle of the one before.
std::array<std::vector<std::uint32_t>, kPairings> random_permutations(std::size_t size, std::uint64_t seed) {
  std::array<std::vector<std::uint32_t>, kPairings> permutations;
  std::vector<std::uint32_t> rows(size);
  std::iota(rows.begin(), rows.end(), 0U);
  for (std::uint32_t p = 0; p < kPairings; ++p) {
    CounterRandom random(seed, RandomStage::pairing, p);
    for (auto left = static_cast<std::uint32_t>(size); left > 1; --left) {
      std::swap(rows[left - 1], rows[random.below(left)]);
    }
    permutations[p] = rows;
  }
  return permutations;
}

// log10 of the expected number of scores above `score`, of greatest values like these of `times` as many seeds.
double log10_of_greater(std::span<const double> greatest, double score, double times) {
  const auto count = static_cast<double>(greatest.size());
  const double mean = std::accumulate(greatest.begin(), greatest.end(), 0.0) / count;
  double squares = 0.0;
  for (const double value : greatest) squares += (value - mean) * (value - mean);
  // Greatest values scatter by pi / sqrt 6 times the scale of their tail, and grow by it with the logarithm of the
  // number of seeds.
  const double tail = std::max(kLeastTail, std::sqrt(6.0 * squares / (count - 1.0)) / std::numbers::pi);
  return std::min(0.0, (mean - score) / tail + std::log(times)) / std::numbers::ln10;
}

}  // namespace

double log10_false_poses(const Correspondences& correspondences, const PoseTest& test, const PoseCandidate& best,
                         std::uint32_t seeds, const Significance& closed_form) {
  if (correspondences.size() < kLeastRowsForPairings || closed_form.log10_false_poses <= kLog10ClosedFormBelieved ||
      closed_form.log10_false_poses >= kLog10PairingsUseless ||
      clustered_share(correspondences.view()) >= kClusteredShareWithoutPairings) {
    return closed_form.log10_false_poses;
  }
  return log10_chance_of_score(correspondences, test, best.support.score * closed_form.independent_share, seeds);
}

double log10_chance_of_score(const Correspondences& correspondences, const PoseTest& test, double score,
                             std::uint32_t seeds) {
  const std::uint32_t max_seeds = std::min(kSeedsPerPairing, seeds);
  const auto targets = random_permutations(correspondences.size(), test.seed);
  std::vector<std::uint32_t> sources(correspondences.size());
  std::iota(sources.begin(), sources.end(), 0U);
  std::array<double, kPairings> scores{};
  double log10_poses = 0.0;
  for (std::uint32_t first = 0; first < kPairings; first += kWave) {
    tbb::parallel_for(first, first + kWave, [&](std::uint32_t p) {
      Correspondences pairing;
      pairing.assign_pairs(correspondences, sources, targets[p]);
      scores[p] = std::max(kLeastScore, test.search(pairing, test.seed + p, max_seeds));
    });
    log10_poses =
        log10_of_greater(std::span(scores).first(first + kWave), score, static_cast<double>(seeds) / max_seeds);
    if (std::abs(log10_poses - kSignificant) > kLog10MarginOfDecision) break;
  }
  return log10_poses;
}

}  // namespace consimd::detail
