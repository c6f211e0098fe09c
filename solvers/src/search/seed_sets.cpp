#include "search/seed_sets.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>
#include <numeric>

#include <consimd/kernels/length_consistency.hpp>

#include "bits/bit_rows.hpp"
#include "call/stage_clock.hpp"

namespace consimd::detail {
namespace {

// Members of a set that a window should show, about, and the window of the first round, whose sets may have any size.
constexpr double kShown = 80.0;
constexpr std::size_t kFirstWindow = 1024;
constexpr double kWindowSlack = 1.5;
// Share of all pairs that are consistent from which samples of sets tell too little, and the matrix of a window of so
// many rows is better than one matrix per set; after many seeds less will do. Where the budget allows only smaller ones
// than the least there is none.
constexpr double kDense = 0.15;
constexpr double kDenseLater = 0.085;
constexpr std::uint32_t kManySeeds = 100;
constexpr std::size_t kLargestMatrix = 3072;
constexpr std::size_t kLeastMatrix = 512;
// Pairs of a task worth its scheduling.
constexpr std::size_t kPairsPerTask = 24'000;
// Largest set, after the second point, whose own matrix is built; larger ones are thinned evenly.
constexpr std::size_t kLargestSet = 160;
constexpr std::size_t kLargestCarefulSet = 256;
// Second points tried by the matrix, about.
constexpr std::size_t kMatrixPartners = 48;
// Larger sets are reduced by a second point.
constexpr std::uint32_t kTwoPoint = 96;
// A set is sampled with this many members, of which this many are tried as the second point.
constexpr std::size_t kSample = kBlock;
constexpr std::size_t kPartners = 16;
// Guesses scatter: sets down to these shares of the best guess, and of the support to beat, are kept.
constexpr float kSlack = 0.5F;
constexpr float kSupportSlack = 0.8F;
// Sets whose guess is below this quantile of all guesses so far look like those of outliers.
constexpr double kUnusual = 0.88;
constexpr std::size_t kManyInliers = 8;
// Least score of the poses met at a glance, as a share of the support wanted.
constexpr double kGlanceShare = 0.1;

// Keeps `count` members at even distances.
void thin(std::vector<std::uint32_t>& members, std::size_t count) {
  const std::size_t size = members.size();
  if (size <= count) return;
  for (std::size_t i = 0; i < count; ++i) members[i] = members[i * size / count];
  members.resize(count);
}

}  // namespace

SeedSets::SeedSets(const Correspondences& correspondences, double consistency_bound, std::uint64_t seed,
                   std::size_t matrix_budget_bytes)
    : correspondences_(correspondences),
      bound_(consistency_bound),
      matrix_budget_bytes_(matrix_budget_bytes),
      random_(seed, RandomStage::permutation, 0),
      order_(correspondences.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
}

void SeedSets::start_over_carefully() {
  drawn_ = 0;
  careful_ = true;
}

double SeedSets::window_share() const {
  return static_cast<double>(window_.size()) / static_cast<double>(order_.size());
}

std::span<const std::uint64_t> SeedSets::bits_of(std::uint32_t position) const {
  if (by_matrix_) return matrix_.row(first_ - window_first_ + position);
  const std::size_t words = window_.view().words();
  return std::span(bits_).subspan(position * words, words);
}

// Lets the window start at the round's seeds, unless it holds them already.
void SeedSets::move_window(std::size_t size) {
  if (window_.size() == size && first_ >= window_first_ && drawn_ <= window_first_ + size) return;
  const auto total = static_cast<std::uint32_t>(order_.size());
  window_first_ = std::min(first_, static_cast<std::uint32_t>(total - size));
  for (; shuffled_ < window_first_ + size; ++shuffled_) {
    std::swap(order_[shuffled_], order_[shuffled_ + random_.below(total - shuffled_)]);
  }
  window_.assign_subset(correspondences_, std::span(order_).subspan(window_first_, size));
  matrix_ = {};
}

// Rows of the largest matrix that is useful and fits the budget; 0 when none is.
std::size_t SeedSets::matrix_size() const {
  const std::size_t least = std::min(order_.size(), kLeastMatrix);
  std::size_t size = careful_ ? order_.size() : std::min(order_.size(), kLargestMatrix);
  while (size >= least && ConsistencyMatrix::memory_bytes(size) > matrix_budget_bytes_) size -= 1 + size / 16;
  return size >= least ? size : 0;
}

// `share`: of the pairs tested last, those that are consistent; 0 before the first round.
std::size_t SeedSets::window_size(double share) const {
  const std::size_t size = order_.size();
  const double wanted = careful_      ? static_cast<double>(size)
                        : share > 0.0 ? std::min(kShown / share, static_cast<double>(size))
                                      : static_cast<double>(std::min(kFirstWindow, size));
  const auto current = static_cast<double>(window_.size());
  if (wanted < kWindowSlack * current && current < kWindowSlack * wanted) return window_.size();
  const std::size_t words = (static_cast<std::size_t>(wanted) + kBlock - 1) / kBlock;
  return std::min(words * kBlock, size);
}

void SeedSets::draw(std::uint32_t count, bool dense_work) {
  const StageClock clock(one_point_seconds_);
  double share = 0.0;
  if (!counts_.empty()) {
    share = static_cast<double>(std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0})) /
            static_cast<double>(counts_.size() * window_.size());
  }
  const bool dense = share > (careful_ || drawn_ > kManySeeds ? kDenseLater : kDense);
  first_ = drawn_;
  drawn_ += count;
  counts_.resize(count);
  sets_.resize(std::max<std::size_t>(sets_.size(), count));
  by_matrix_ = (by_matrix_ || (dense && dense_work)) && matrix_size() > 0;
  if (by_matrix_) {
    move_window(matrix_size());
    if (matrix_.size() == 0) matrix_.compute(window_, bound_);
    for (std::uint32_t h = 0; h < count; ++h) counts_[h] = matrix_.degrees()[first_ - window_first_ + h];
    return;
  }
  move_window(window_size(share));
  seeds_.resize(count);
  std::iota(seeds_.begin(), seeds_.end(), first_ - window_first_);
  const std::size_t words = window_.view().words();
  bits_.resize(count * words);
  const std::size_t grain = std::clamp<std::size_t>(kPairsPerTask / window_.size(), 2, 8);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    length_consistency_bits(window_, std::span(seeds_).subspan(r.begin(), r.size()), bound_,
                            std::span(bits_).subspan(r.begin() * words, r.size() * words),
                            std::span(counts_).subspan(r.begin(), r.size()));
  });
}

// A two-point hypothesis (seed, partner) for the price of a few hundred pairs: the largest clique through the seed is
// guessed from a sample of its set, as the best partner's consensus within it.
SeedSets::Guess SeedSets::guess(std::uint32_t position, Scratch& scratch) const {
  members_of(bits_of(position), scratch.members);
  scratch.sampled = scratch.members;
  // The seed agrees with all of its set and would tell nothing.
  std::erase(scratch.sampled, first_ - window_first_ + position);
  thin(scratch.sampled, kSample);
  scratch.sample.assign_subset(window_, scratch.sampled);
  const std::size_t sampled = scratch.sampled.size();
  scratch.partners.resize(std::min(sampled, kPartners));
  for (std::size_t i = 0; i < scratch.partners.size(); ++i) {
    scratch.partners[i] = static_cast<std::uint32_t>(i * sampled / scratch.partners.size());
  }
  scratch.counts.resize(scratch.partners.size());
  length_consistency_counts(scratch.sample.view(), scratch.partners, bound_, scratch.counts);
  const auto best = std::max_element(scratch.counts.begin(), scratch.counts.end());
  const std::uint32_t partner = scratch.partners[static_cast<std::size_t>(best - scratch.counts.begin())];
  return {static_cast<float>(*best) * static_cast<float>(scratch.members.size()) / static_cast<float>(sampled),
          window_row(scratch.sampled[partner])};
}

// The same by the matrix: what the best partner has in common with the seed beyond chance.
SeedSets::Guess SeedSets::guess_by_matrix(std::uint32_t position, Scratch& scratch) const {
  const std::span<const std::uint64_t> set = bits_of(position);
  const std::size_t stride = 1 + set.size() / kMatrixPartners;
  scratch.partners.clear();
  for (std::size_t w = 0; w < set.size(); w += stride) {
    if (set[w] == 0) continue;
    const auto partner = static_cast<std::uint32_t>(w * kBlock + static_cast<std::size_t>(std::countr_zero(set[w])));
    if (partner != first_ - window_first_ + position) scratch.partners.push_back(partner);
  }
  scratch.counts.resize(scratch.partners.size());
  and_popcount_rows(matrix_, set, scratch.partners, scratch.counts);
  const auto size = static_cast<float>(counts_[position]);
  Guess best;
  for (std::size_t i = 0; i < scratch.partners.size(); ++i) {
    const std::uint32_t partner = scratch.partners[i];
    const float chance = static_cast<float>(matrix_.degrees()[partner]) / static_cast<float>(matrix_.size());
    if (chance >= 1.0F) continue;
    const float clique = (static_cast<float>(scratch.counts[i]) - chance * size) / (1.0F - chance);
    if (clique > best.clique) best = {clique, window_row(partner)};
  }
  return best;
}

// With a large support found, the usual set may be that of an inlier.
bool SeedSets::outliers_are_usual(std::uint32_t support) const { return support < order_.size() / kManyInliers; }

std::span<const std::uint32_t> SeedSets::rank(std::uint32_t support_to_beat, const Skip& skip) {
  const StageClock clock(two_point_seconds_);
  const std::uint32_t count = drawn_ - first_;
  // Supporters of a pose within the noise bound are pairwise consistent: a set holds the clique or is too small for it.
  const double share = window_share();
  const auto largest = static_cast<double>(std::ranges::max(counts_));
  largest_raw_set_ = std::max(largest_raw_set_, static_cast<std::size_t>(largest / share));
  const double least_count = (share < 1.0 ? kSupportSlack * share : 1.0) * support_to_beat;
  // A set no larger than what stood out so far cannot stand out.
  const float small = outliers_are_usual(support_to_beat) ? unusual_guess_ * static_cast<float>(share) : 0.0F;
  guesses_.assign(count, {});
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 4), [&](const tbb::blocked_range<std::uint32_t>& r) {
    Scratch& scratch = scratch_.local();
    for (std::uint32_t h = r.begin(); h < r.end(); ++h) {
      const auto size = static_cast<float>(counts_[h]);
      if (counts_[h] < 3 || size <= least_count || size < small || skip(seed_row(h))) continue;
      guesses_[h] = !by_matrix_ ? guess(h, scratch) : careful_ ? Guess{size, 0} : guess_by_matrix(h, scratch);
      guesses_[h].clique /= static_cast<float>(share);
    }
  });
  unusual_guess_ = 0.0F;
  if (!by_matrix_ && !careful_) {
    for (std::uint32_t h = 0; h < count; ++h) {
      const auto size = static_cast<float>(counts_[h]);
      if (guesses_[h].clique > 0.0F || (size > least_count && size < small)) {
        all_guesses_.push_back(guesses_[h].clique > 0.0F ? guesses_[h].clique : size / static_cast<float>(share));
      }
    }
    const auto rank = static_cast<std::size_t>(kUnusual * static_cast<double>(all_guesses_.size()));
    const auto quantile = all_guesses_.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(all_guesses_.begin(), quantile, all_guesses_.end());
    if (quantile != all_guesses_.end()) unusual_guess_ = *quantile;
  }
  const float best = std::ranges::max_element(guesses_, {}, &Guess::clique)->clique;
  const float least = std::max({kSlack * best, kSupportSlack * static_cast<float>(support_to_beat), 3.0F});
  ranking_.clear();
  for (std::uint32_t h = 0; h < count; ++h) {
    if (guesses_[h].clique >= least) ranking_.push_back(h);
  }
  std::ranges::stable_sort(ranking_, std::greater<>(), [&](std::uint32_t h) { return guesses_[h].clique; });
  return ranking_;
}

std::span<const std::uint32_t> SeedSets::promising(std::span<const std::uint32_t> ranking,
                                                   std::uint32_t support_to_beat, const Skip& skip) {
  const float least = std::max(kSupportSlack * static_cast<float>(support_to_beat),
                               outliers_are_usual(support_to_beat) ? unusual_guess_ : 0.0F);
  promising_.clear();
  std::ranges::copy_if(ranking, std::back_inserter(promising_),
                       [&](std::uint32_t h) { return guesses_[h].clique >= least && !skip(seed_row(h)); });
  ranking_.swap(promising_);
  return ranking_;
}

// The rows that agree with the seed and, if they are many, with its partner.
void SeedSets::two_point_set(std::uint32_t position, Scratch& scratch, std::vector<std::uint32_t>& set) const {
  const std::size_t words = correspondences_.view().words();
  const std::uint32_t pair[] = {seed_row(position), guesses_[position].partner};
  std::uint32_t counts[2];
  scratch.bits.resize(2 * words);
  length_consistency_bits(correspondences_, pair, bound_, scratch.bits, counts);
  const std::span<std::uint64_t> bits = std::span(scratch.bits).first(words);
  if (!careful_ && counts[0] > kTwoPoint) {
    for (std::size_t w = 0; w < words; ++w) bits[w] &= scratch.bits[words + w];
  }
  members_of(bits, set);
}

// Whether minimal poses through the seed, its partner and a few others of the set promise `wanted` supporters.
bool SeedSets::promises_pose(std::uint32_t position, std::span<const std::uint32_t> set, double wanted,
                             Scratch& scratch) const {
  scratch.sampled.assign({seed_row(position), guesses_[position].partner});
  scratch.sampled.insert(scratch.sampled.end(), set.begin(), set.end());
  return score_at_a_glance(correspondences_, scratch.sampled, 0.5 * bound_, scratch.poses) > kGlanceShare * wanted;
}

void SeedSets::prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat, bool settled) {
  const StageClock clock(two_point_seconds_);
  const std::uint32_t wanted = std::max(support_to_beat + 1, 3U);
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    Scratch& scratch = scratch_.local();
    std::vector<std::uint32_t>& set = sets_[positions[i]];
    // A part of a set should hold about its share of the clique.
    const auto part_of_wanted = [&](double share) {
      return share < 1.0 ? std::max(static_cast<std::uint32_t>(kSlack * share * wanted), 3U) : wanted;
    };
    if (by_matrix_) {
      members_of(bits_of(positions[i]), set);
      detail::prune(matrix_, set, part_of_wanted(window_share()), Merit::excess, scratch.matrix_prune);
      for (std::uint32_t& member : set) member = window_row(member);
      std::ranges::sort(set);
      return;
    }
    two_point_set(positions[i], scratch, set);
    const auto size = static_cast<double>(set.size());
    thin(set, careful_ ? kLargestCarefulSet : kLargestSet);
    const double share = static_cast<double>(set.size()) / size;
    if (settled && !promises_pose(positions[i], set, share * wanted, scratch)) {
      set.clear();
    } else {
      scratch.set_pruner.prune(correspondences_, set, bound_, part_of_wanted(share));
    }
  });
}

}  // namespace consimd::detail
