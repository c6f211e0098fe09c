#include "chance_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "clustering.hpp"
#include "consensus_search.hpp"
#include "counter_random.hpp"

namespace consimd::detail {
namespace {

constexpr std::uint32_t kPairings = 6;
constexpr std::uint32_t kSeedsPerPairing = 192;
// Least scale of the scores' exponential tail, in supporters: six pairings tell their own only roughly.
constexpr double kLeastTail = 0.35;

// Fewer correspondences have scores in steps too coarse for a tail, and few triples for the closed form to count.
constexpr std::size_t kFew = 128;

// Score of a pairing without any pose. Three supporters are not much more than none.
constexpr double kLeastScore = 2.0;

// Share of clustered correspondences from which random pairings are no match for them.
constexpr double kClustered = 0.25;

}  // namespace

double log10_false_poses(const Correspondences& correspondences, const TcfOptions& options, const PoseCandidate& best,
                         std::uint32_t seeds, const Significance& closed_form) {
  if (correspondences.size() < kFew || closed_form.log10_false_poses <= kSure ||
      closed_form.log10_false_poses >= kHopeless || clustered_share(correspondences.view()) >= kClustered) {
    return closed_form.log10_false_poses;
  }
  return log10_chance_of_score(correspondences, options, best.support.score * closed_form.independent_share, seeds);
}

double log10_chance_of_score(const Correspondences& correspondences, const TcfOptions& options, double score,
                             std::uint32_t seeds) {
  std::vector<std::uint32_t> sources(correspondences.size());
  std::iota(sources.begin(), sources.end(), 0U);
  std::vector<std::uint32_t> targets = sources;
  Correspondences pairing;
  TcfOptions chance_options = options;
  chance_options.max_seeds = std::min(kSeedsPerPairing, seeds);
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint32_t p = 0; p < kPairings; ++p) {
    CounterRandom random(options.seed, RandomStage::pairing, p);
    for (auto left = static_cast<std::uint32_t>(targets.size()); left > 1; --left) {
      std::swap(targets[left - 1], targets[random.below(left)]);
    }
    pairing.assign_pairs(correspondences, sources, targets);
    chance_options.seed = options.seed + p;
    ConsensusSearch search(pairing, chance_options);
    search.run(false);
    const double best = std::max<double>(kLeastScore, search.best().support.score);
    sum += best;
    squares += best * best;
  }
  const double mean = sum / kPairings;
  const double deviation = std::sqrt(std::max(0.0, (squares - sum * mean) / (kPairings - 1)));
  // Greatest values scatter by pi / sqrt 6 times the scale of their tail, and grow by it with the logarithm of the
  // number of seeds.
  const double tail = std::max(kLeastTail, deviation * std::sqrt(6.0) / std::numbers::pi);
  const double more_seeds = std::log(static_cast<double>(seeds) / chance_options.max_seeds);
  return std::min(0.0, (mean - score) / tail + more_seeds) / std::numbers::ln10;
}

}  // namespace consimd::detail
