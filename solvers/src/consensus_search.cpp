#include "consensus_search.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "counter_random.hpp"
#include "sampling.hpp"
#include "stage_clock.hpp"

namespace consimd::detail {
namespace {

// Rounds of seeds grow from the first to the last size: few for easy problems, enough to keep many threads busy in hard
// ones.
constexpr std::uint32_t kFirstRound = 4;
constexpr std::uint32_t kLargestRound = 64;
// The sets tried first in a round; the others must promise more than what these gave.
constexpr std::size_t kFirstWave = 2;
// Sets and poses this much worse than the best of their round are not worth a fit.
constexpr float kWorthFitting = 0.5F;
constexpr float kWorthOptimising = 0.8F;
// Random pairings searched, and the least scale of the scores' exponential tail, in supporters.
constexpr std::uint64_t kPairings = 4;
constexpr double kLeastTail = 0.45;

bool lower_score(const PoseCandidate& a, const PoseCandidate& b) { return a.support.score < b.support.score; }

}  // namespace

ConsensusSearch::ConsensusSearch(const Correspondences& correspondences, const TcfOptions& options)
    : correspondences_(correspondences),
      options_(options),
      sets_(correspondences, 2.0 * options.noise_bound, options.seed, options.matrix_budget_bytes) {}

std::uint64_t ConsensusSearch::seeds_needed() const {
  const auto size = static_cast<double>(correspondences_.size());
  const double share = best_.support.count < 3 ? 0.0 : best_.support.count / size;
  return std::min<std::uint64_t>(iterations_needed(options_.confidence, share, 1), correspondences_.size());
}

bool ConsensusSearch::confident() const { return sets_.drawn() >= seeds_needed(); }

void ConsensusSearch::run(bool exhaustive) {
  const std::uint64_t limit = std::min<std::uint64_t>(correspondences_.size(), options_.max_seeds);
  const auto wanted = [&] { return static_cast<std::uint32_t>(exhaustive ? limit : std::min(limit, seeds_needed())); };
  for (std::uint32_t round = kFirstRound; sets_.drawn() < wanted(); round = std::min(2 * round, kLargestRound)) {
    const std::uint32_t left = wanted() - sets_.drawn();
    sets_.draw(std::min(round, left), left > kLargestRound);
    std::span<const std::uint32_t> ranking = sets_.rank(best_.support.count);
    for (std::size_t wave = kFirstWave; !ranking.empty(); wave = ranking.size()) {
      wave = std::min(wave, ranking.size());
      sets_.prune(ranking.first(wave), best_.support.count);
      fit_sets(ranking.first(wave));
      if (sets_.drawn() >= wanted()) break;
      ranking = sets_.promising(ranking.subspan(wave), best_.support.count);
    }
  }
}

void ConsensusSearch::fit_sets(std::span<const std::uint32_t> positions) {
  const StageClock clock(three_point_seconds_);
  std::size_t largest = 0;
  for (const std::uint32_t h : positions) largest = std::max(largest, sets_.set(h).size());
  const float least = std::max(3.0F, kWorthFitting * static_cast<float>(largest));
  std::vector<std::uint32_t> fitted;
  std::copy_if(positions.begin(), positions.end(), std::back_inserter(fitted),
               [&](std::uint32_t h) { return static_cast<float>(sets_.set(h).size()) >= least; });
  if (fitted.empty()) return;

  candidates_.resize(fitted.size());
  tbb::parallel_for(std::size_t{0}, fitted.size(), [&](std::size_t i) {
    candidates_[i] = pose_of_set(correspondences_, sets_.set(fitted[i]), options_.noise_bound, options_.seed,
                                 sets_.drawn() + fitted[i], scratch_.local());
  });
  minimal_fits_ += fitted.size() * kTriplesPerSet;
  const auto winner = std::max_element(candidates_.begin(), candidates_.end(), lower_score);
  if (winner->support.score <= kWorthOptimising * best_.support.score) return;
  const PoseCandidate optimised = locally_optimise(correspondences_, *winner, options_.noise_bound);
  if (optimised.support.score <= best_.support.score) return;
  best_ = optimised;
  best_set_ = sets_.set(fitted[static_cast<std::size_t>(winner - candidates_.begin())]);
}

double log10_chance_of_score(const Correspondences& correspondences, const TcfOptions& options, double score) {
  std::vector<std::uint32_t> sources(correspondences.size());
  std::iota(sources.begin(), sources.end(), 0U);
  std::vector<std::uint32_t> targets = sources;
  Correspondences pairing;
  TcfOptions chance_options = options;
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint64_t p = 0; p < kPairings; ++p) {
    CounterRandom random(options.seed, RandomStage::pairing, p);
    for (auto left = static_cast<std::uint32_t>(targets.size()); left > 1; --left) {
      std::swap(targets[left - 1], targets[random.below(left)]);
    }
    pairing.assign_pairs(correspondences, sources, targets);
    chance_options.seed = options.seed + p;
    ConsensusSearch search(pairing, chance_options);
    search.run(false);
    sum += search.best().support.score;
    squares += search.best().support.score * search.best().support.score;
  }
  const double mean = sum / kPairings;
  const double deviation = std::sqrt(std::max(0.0, (squares - sum * mean) / (kPairings - 1)));
  // Greatest values scatter by pi / sqrt 6 times the scale of their tail.
  const double tail = std::max(kLeastTail, deviation * std::sqrt(6.0) / std::numbers::pi);
  return std::min(0.0, (mean - score) / tail) / std::numbers::ln10;
}

}  // namespace consimd::detail
