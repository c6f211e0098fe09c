#include "seed_sets.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>
#include <numeric>

#include <consimd/kernels/length_consistency.hpp>

#include "counter_random.hpp"
#include "stage_clock.hpp"

namespace consimd::detail {
namespace {

// Share of all pairs that are consistent from which samples of sets tell too little, and the matrix of all
// correspondences is better than one matrix per set; after many seeds less will do.
constexpr double kDense = 0.15;
constexpr double kDenseLater = 0.085;
constexpr std::uint32_t kManySeeds = 100;
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
// Estimates scatter: sets down to these shares of the best estimate, and of the support to beat, are kept.
constexpr float kSlack = 0.5F;
constexpr float kSupportSlack = 0.8F;
// Sets whose estimate does not exceed the usual one, the median so far, by this factor look like those of outliers.
constexpr float kUnusual = 1.25F;
constexpr std::size_t kManyInliers = 8;

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
      seed_(seed),
      matrix_budget_bytes_(matrix_budget_bytes),
      order_(correspondences.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
}

void SeedSets::start_over_carefully() {
  drawn_ = 0;
  careful_ = true;
}

std::span<const std::uint64_t> SeedSets::row(std::uint32_t position) const {
  if (matrix_.size() != 0) return matrix_.row(round_[position]);
  const std::size_t words = correspondences_.view().words();
  return std::span(bits_).subspan(position * words, words);
}

void SeedSets::draw(std::uint32_t count, bool dense_work) {
  const StageClock clock(one_point_seconds_);
  const CorrespondenceView view = correspondences_.view();
  const auto size = static_cast<std::uint32_t>(order_.size());
  for (std::uint32_t last = drawn_ + count; drawn_ < last; ++drawn_) {
    if (drawn_ < shuffled_) continue;
    CounterRandom random(seed_, RandomStage::permutation, drawn_);
    std::swap(order_[drawn_], order_[drawn_ + random.below(size - drawn_)]);
    ++shuffled_;
  }
  if (matrix_.size() == 0 && dense_work && !counts_.empty()) {
    const double ones = static_cast<double>(std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0}));
    const double share = careful_ || drawn_ - count > kManySeeds ? kDenseLater : kDense;
    const bool dense = ones > share * static_cast<double>(counts_.size()) * size;
    if (dense && ConsistencyMatrix::memory_bytes(size) <= matrix_budget_bytes_) matrix_.compute(view, bound_);
  }

  round_ = std::span(order_).subspan(drawn_ - count, count);
  counts_.resize(count);
  sets_.resize(std::max<std::size_t>(sets_.size(), count));
  if (matrix_.size() != 0) {
    for (std::uint32_t h = 0; h < count; ++h) counts_[h] = matrix_.degrees()[round_[h]];
    return;
  }
  bits_.resize(count * view.words());
  const std::size_t grain = std::clamp<std::size_t>(kPairsPerTask / std::max(size, 1U), 2, 8);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain), [&](const tbb::blocked_range<std::size_t>& r) {
    length_consistency_bits(view, round_.subspan(r.begin(), r.size()), bound_,
                            std::span(bits_).subspan(r.begin() * view.words(), r.size() * view.words()),
                            std::span(counts_).subspan(r.begin(), r.size()));
  });
}

// A two-point hypothesis (seed, partner) for the price of a few hundred pairs: the largest clique through the seed is
// guessed from a sample of its set, as the best partner's consensus within it.
SeedSets::Guess SeedSets::guess(std::uint32_t position, Scratch& scratch) const {
  members_of(row(position), scratch.members);
  scratch.sampled = scratch.members;
  std::erase(scratch.sampled, round_[position]);  // the seed agrees with all of its set and would tell nothing
  thin(scratch.sampled, kSample);
  scratch.sample.assign_subset(correspondences_, scratch.sampled);
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
          scratch.sampled[partner]};
}

// The same by the matrix: what the best partner has in common with the seed beyond chance.
float SeedSets::clique_by_matrix(std::uint32_t position, Scratch& scratch) const {
  const std::span<const std::uint64_t> set = row(position);
  const std::size_t stride = 1 + set.size() / kMatrixPartners;
  scratch.partners.clear();
  for (std::size_t w = 0; w < set.size(); w += stride) {
    if (set[w] == 0) continue;
    const auto partner = static_cast<std::uint32_t>(w * kBlock + static_cast<std::size_t>(std::countr_zero(set[w])));
    if (partner != round_[position]) scratch.partners.push_back(partner);
  }
  scratch.counts.resize(scratch.partners.size());
  and_popcount_rows(matrix_, set, scratch.partners, scratch.counts);
  const auto size = static_cast<float>(counts_[position]);
  float most = 0.0F;
  for (std::size_t i = 0; i < scratch.partners.size(); ++i) {
    const float chance =
        static_cast<float>(matrix_.degrees()[scratch.partners[i]]) / static_cast<float>(matrix_.size());
    if (chance < 1.0F) most = std::max(most, (static_cast<float>(scratch.counts[i]) - chance * size) / (1.0F - chance));
  }
  return most;
}

std::span<const std::uint32_t> SeedSets::rank(std::uint32_t support_to_beat, const Skip& skip) {
  const StageClock clock(two_point_seconds_);
  const auto count = static_cast<std::uint32_t>(round_.size());
  estimates_.assign(count, 0.0F);
  partners_.resize(count);
  const bool sample = matrix_.size() == 0;
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 4), [&](const tbb::blocked_range<std::uint32_t>& r) {
    Scratch& scratch = scratch_.local();
    for (std::uint32_t h = r.begin(); h < r.end(); ++h) {
      // Supporters of a pose within the noise bound are pairwise consistent: the set holds the clique or is too small
      // for it.
      if (counts_[h] < 3 || counts_[h] <= support_to_beat || skip(round_[h])) continue;
      if (careful_ && !sample) {
        estimates_[h] = static_cast<float>(counts_[h]);
      } else if (sample) {
        const Guess best = guess(h, scratch);
        estimates_[h] = best.clique;
        partners_[h] = best.partner;
      } else {
        estimates_[h] = clique_by_matrix(h, scratch);
      }
    }
  });
  largest_raw_set_ = std::max<std::size_t>(largest_raw_set_, *std::max_element(counts_.begin(), counts_.end()));
  usual_estimate_ = 0.0F;
  if (sample && !careful_) {
    std::copy_if(estimates_.begin(), estimates_.end(), std::back_inserter(all_estimates_),
                 [](float estimate) { return estimate > 0.0F; });
    const auto middle = all_estimates_.begin() + static_cast<std::ptrdiff_t>(all_estimates_.size() / 2);
    std::nth_element(all_estimates_.begin(), middle, all_estimates_.end());
    if (middle != all_estimates_.end()) usual_estimate_ = *middle;
  }
  const float best = *std::max_element(estimates_.begin(), estimates_.end());
  const float least = std::max({kSlack * best, kSupportSlack * static_cast<float>(support_to_beat), 3.0F});
  ranking_.clear();
  for (std::uint32_t h = 0; h < count; ++h) {
    if (estimates_[h] >= least) ranking_.push_back(h);
  }
  std::stable_sort(ranking_.begin(), ranking_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return estimates_[a] > estimates_[b]; });
  return ranking_;
}

std::span<const std::uint32_t> SeedSets::promising(std::span<const std::uint32_t> ranking,
                                                   std::uint32_t support_to_beat, const Skip& skip) {
  // With a large support found, the usual set may be that of an inlier.
  const bool usual_is_wrong = support_to_beat < order_.size() / kManyInliers;
  const float least =
      std::max(kSupportSlack * static_cast<float>(support_to_beat), usual_is_wrong ? kUnusual * usual_estimate_ : 0.0F);
  promising_.clear();
  std::copy_if(ranking.begin(), ranking.end(), std::back_inserter(promising_), [&](std::uint32_t h) {
    return estimates_[h] >= least && counts_[h] > support_to_beat && !skip(round_[h]);
  });
  ranking_.swap(promising_);
  return ranking_;
}

void SeedSets::prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat) {
  const StageClock clock(two_point_seconds_);
  const std::uint32_t wanted = std::max(support_to_beat + 1, 3U);
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    Scratch& scratch = scratch_.local();
    std::vector<std::uint32_t>& set = sets_[positions[i]];
    if (matrix_.size() != 0) {
      members_of(row(positions[i]), set);
      detail::prune(matrix_, set, wanted, Merit::excess, scratch.matrix_prune);
      return;
    }
    const std::span<const std::uint64_t> of_seed = row(positions[i]);
    scratch.bits.assign(of_seed.begin(), of_seed.end());
    if (!careful_ && counts_[positions[i]] > kTwoPoint) {
      scratch.partner_bits.resize(of_seed.size());
      std::uint32_t count = 0;
      length_consistency_bits(correspondences_.view(), std::span(&partners_[positions[i]], 1), bound_,
                              scratch.partner_bits, std::span(&count, 1));
      std::transform(of_seed.begin(), of_seed.end(), scratch.partner_bits.begin(), scratch.bits.begin(),
                     std::bit_and<>());
    }
    members_of(scratch.bits, set);
    const std::size_t size = set.size();
    thin(set, careful_ ? kLargestCarefulSet : kLargestSet);
    // A thinned set holds its share of the clique, more or less.
    const auto share =
        static_cast<std::uint32_t>(kSlack * static_cast<float>(wanted * set.size()) / static_cast<float>(size));
    scratch.set_pruner.prune(correspondences_, set, bound_, set.size() == size ? wanted : std::max(share, 3U));
  });
}

}  // namespace consimd::detail
