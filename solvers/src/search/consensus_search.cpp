#include "search/consensus_search.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "call/stage_clock.hpp"
#include "sampling/sampling.hpp"
#include "search/sparse_sets.hpp"
#include "support/pose_candidate.hpp"
#include "support/repeated_points.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {
namespace {

// That a seed of any pose that may become the best or its rival has been drawn, in a search with care, if no more is
// asked for.
constexpr double kCarefulConfidence = 0.999;

// A seed that is looked at with care takes so many times the time of another: of 3000 rows of the noise study, 99.75 %
// outliers and 1 m, some 17 microseconds and its share of the poses in place of 11.
constexpr double kTimeOfCare = 2.0;
// Sets of so many rows tell nothing.
constexpr std::uint32_t kSmallestSets = 3;
// Sets whose poses are fitted before it is known which of the others are still of interest.
constexpr std::size_t kSetsAtOnce = 64;

bool lower_score(const PoseCandidate& a, const PoseCandidate& b) { return a.support.score < b.support.score; }

}  // namespace

ConsensusSearch::ConsensusSearch(const Correspondences& correspondences, const ConsensusSearchOptions& options)
    : correspondences_(correspondences),
      options_(options),
      sets_(correspondences, 2.0 * options.noise_bound, options.seed, options.matrix_budget_bytes, options.tuning),
      poses_(correspondences, options.noise_bound) {}

std::uint64_t ConsensusSearch::seeds_needed() const {
  const auto size = static_cast<double>(correspondences_.size());
  const double share = best().support.count < 3 ? 0.0 : best().support.count / size;
  return std::min<std::uint64_t>(iterations_needed(options_.confidence, share, 1), correspondences_.size());
}

std::uint64_t ConsensusSearch::careful_seeds() const {
  const double share = std::max(support_of_interest(), 3U) / static_cast<double>(correspondences_.size());
  return iterations_needed(std::max(options_.confidence, kCarefulConfidence), share, 1);
}

bool ConsensusSearch::confident() const { return !stopped_ && (exhaustive_ || sets_.drawn() >= seeds_needed()); }

void ConsensusSearch::offer(const WorkingPose& pose) {
  const PoseCandidate start = scored(correspondences_, pose, options_.noise_bound);
  if (poses_.offer(locally_optimise(correspondences_, start, options_.noise_bound))) settle();
}

void ConsensusSearch::run(bool careful) {
  if (exhaustive_) return;
  const std::uint64_t seeds = std::min<std::uint64_t>(correspondences_.size(), careful_seeds());
  if (careful && seeds_for_all() < kTimeOfCare * static_cast<double>(seeds)) look_at_all_sets();
  if (!exhaustive_ && !stopped_) draw_rounds(careful);
  if (!stopped_) look_for_repeated_rival();
}

// Where points are in many rows, another motion may join the supporters' points anew, as the turns of a symmetric part
// do. What such motions have in common with the best one hides them in its sets: they are searched for on their own.
void ConsensusSearch::look_for_repeated_rival() {
  if (best().support.count < 3 || !one_to_many(correspondences_)) return;
  const std::vector<std::uint32_t> supporters = pose_inliers(correspondences_, best().pose, options_.noise_bound);
  // Points in many rows that are not the supporters' are those that everything looks like to a descriptor.
  const double least = (kManyRows - 1.0) * static_cast<double>(supporters.size());
  if (static_cast<double>(correspondences_.size() - supporters.size()) < least) return;
  const std::vector<std::uint32_t> rows = rows_sharing_a_point(correspondences_, supporters);
  if (static_cast<double>(rows.size()) < least) return;
  const Correspondences others = correspondences_.subset(rows);
  ConsensusSearch search(others, options_);
  search.draw_rounds(false);
  stopped_ = search.stopped();
  if (search.best().support.count < 3) return;
  const PoseCandidate rival = scored(correspondences_, search.best().pose, options_.noise_bound);
  if (!poses_.offer(locally_optimise(correspondences_, rival, options_.noise_bound))) return;
  best_set_.clear();
  for (const std::uint32_t position : search.best_set()) best_set_.push_back(rows[position]);
  settle();
}

void ConsensusSearch::draw_rounds(bool careful) {
  const RoundTuning& rounds = options_.tuning.round;
  if (careful) sets_.start_over(with_care(options_.tuning));
  const std::uint64_t limit = std::min<std::uint64_t>(correspondences_.size(), options_.max_seeds);
  const auto wanted = [&] {
    return static_cast<std::uint32_t>(std::min(limit, careful ? careful_seeds() : seeds_needed()));
  };
  // A seed that the best pose moves to its target would lead to that pose again.
  const auto explained = [&](std::uint32_t row) {
    return poses_.best_explains(row) || (settled_ && poses_.runner_up_explains(row));
  };
  for (std::uint32_t round = rounds.first; sets_.drawn() < wanted(); round = std::min(2 * round, rounds.largest)) {
    if (options_.stop.met()) {
      stopped_ = true;
      return;
    }
    const std::uint32_t left = wanted() - sets_.drawn();
    sets_.draw(std::min(round, left), left > rounds.largest);
    std::span<const std::uint32_t> ranking = sets_.rank(support_of_interest(), explained);
    for (std::size_t wave = rounds.first_wave; !ranking.empty(); wave = ranking.size()) {
      wave = std::min(wave, ranking.size());
      sets_.prune(ranking.first(wave), support_of_interest(), settled_.has_value());
      fit_round(ranking.first(wave));
      ranking = sets_.promising(ranking.subspan(wave), support_of_interest(), explained);
    }
    // Once seeds have taken as long as looking at all sets does, and would take longer still: whatever the best is
    // then, no more than twice the time is spent.
    const double all = settled_ ? std::numeric_limits<double>::infinity() : seeds_for_all();
    if (sets_.drawn() >= all && wanted() > sets_.drawn() + all) look_at_all_sets();
    if (exhaustive_ || stopped_) return;
  }
}

double ConsensusSearch::seeds_for_all() const {
  const bool may_look = correspondences_.size() <= options_.max_seeds && !tried_all_;
  if (!may_look) return std::numeric_limits<double>::infinity();
  return seeds_for_all_sets(correspondences_.size(), sets_.share(), options_.matrix_budget_bytes);
}

void ConsensusSearch::look_at_all_sets() {
  tried_all_ = true;
  const std::uint32_t least = std::max(support_of_interest(), kSmallestSets) + 1;
  const SparseSets found = [&] {
    const StageClock clock(all_sets_seconds_);
    return sparse_sets(correspondences_, 2.0 * options_.noise_bound, least, options_.stop);
  }();
  const std::vector<std::vector<std::uint32_t>>& sets = found.sets;
  std::vector<SetToFit> fitted;
  for (std::size_t first = 0; first < sets.size() && sets[first].size() > support_of_interest(); first += kSetsAtOnce) {
    stopped_ = options_.stop.met();
    if (stopped_) return;
    fitted.clear();
    for (std::size_t k = first; k < std::min(first + kSetsAtOnce, sets.size()); ++k) {
      // Two rows determine no other pose.
      const auto others = std::ranges::count_if(sets[k], [&](std::uint32_t row) { return !poses_.best_explains(row); });
      if (others > 2) fitted.push_back({&sets[k], sets_.drawn() + k});
    }
    fit_sets(fitted);
  }
  exhaustive_ = found.all;
}

// Support from which a pose may become the best or its rival.
std::uint32_t ConsensusSearch::support_of_interest() const {
  return static_cast<std::uint32_t>(kRivalShare * best().support.count);
}

void ConsensusSearch::fit_round(std::span<const std::uint32_t> positions) {
  std::vector<SetToFit> fitted;
  for (const std::uint32_t h : positions) {
    if (sets_.set(h).size() >= 3) fitted.push_back({&sets_.set(h), sets_.drawn() + h});
  }
  fit_sets(fitted);
}

void ConsensusSearch::fit_sets(std::span<const SetToFit> sets) {
  const StageClock clock(three_point_seconds_);
  const ThreePointTuning& tuning = options_.tuning.three_point;
  if (sets.empty()) return;

  candidates_.resize(sets.size());
  tbb::parallel_for(std::size_t{0}, sets.size(), [&](std::size_t i) {
    candidates_[i] = pose_of_set(correspondences_, *sets[i].rows, options_.noise_bound, options_.seed,
                                 sets[i].hypothesis, support_of_interest(), tuning, scratch_.local());
  });
  minimal_fits_ += sets.size() * tuning.triples;
  const auto winner = std::max_element(candidates_.begin(), candidates_.end(), lower_score);
  if (winner->support.score > kRivalShare * best().support.score) {
    *winner = locally_optimise(correspondences_, *winner, options_.noise_bound);
  }
  bool improved = false;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (!poses_.offer(candidates_[i])) continue;
    best_set_ = *sets[i].rows;
    improved = true;
  }
  if (improved) settle();
}

void ConsensusSearch::settle() {
  if (!options_.settles) return;
  settled_ = significance(correspondences_, best().pose, options_.noise_bound, Scrutiny::glance);
  if (settled_->log10_false_poses >= kBeyondDoubt) settled_.reset();
}

}  // namespace consimd::detail
