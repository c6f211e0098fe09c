#include "search/sampled_sets.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include <consimd/kernels/length_consistency.hpp>

#include "bits/bit_rows.hpp"

namespace consimd::detail {
namespace {

// Pairs of a task worth its scheduling.
constexpr std::size_t kPairsPerTask = 24'000;

// Keeps `count` members at even distances.
void thin(std::vector<std::uint32_t>& members, std::size_t count) {
  const std::size_t size = members.size();
  if (size <= count) return;
  for (std::size_t i = 0; i < count; ++i) members[i] = members[i * size / count];
  members.resize(count);
}

}  // namespace

SampledSets::SampledSets(const Correspondences& correspondences, double consistency_bound)
    : correspondences_(correspondences), bound_(consistency_bound) {}

void SampledSets::draw(const SeedWindow& window, std::uint32_t begin, std::span<std::uint32_t> sizes) {
  begin_ = begin;
  seeds_.resize(sizes.size());
  std::iota(seeds_.begin(), seeds_.end(), begin);
  const std::size_t words = window.rows().view().words();
  bits_.resize(sizes.size() * words);
  const std::size_t grain = std::clamp<std::size_t>(kPairsPerTask / window.size(), 2, 8);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sizes.size(), grain), [&](const auto& range) {
    const std::size_t first = range.begin();
    length_consistency_bits(window.rows(), std::span(seeds_).subspan(first, range.size()), bound_,
                            std::span(bits_).subspan(first * words, range.size() * words),
                            sizes.subspan(first, range.size()));
  });
}

SetGuess SampledSets::guess(const SeedWindow& window, std::uint32_t position, const TwoPointTuning& tuning) {
  Scratch& scratch = scratch_.local();
  const std::size_t words = window.rows().view().words();
  members_of(std::span(bits_).subspan(position * words, words), scratch.members);
  scratch.sampled = scratch.members;
  // The seed agrees with all of its set and would tell nothing.
  std::erase(scratch.sampled, begin_ + position);
  thin(scratch.sampled, tuning.sample);
  scratch.sample.assign_subset(window.rows(), scratch.sampled);
  const std::size_t sampled = scratch.sampled.size();
  scratch.partners.resize(std::min(sampled, tuning.partners));
  for (std::size_t i = 0; i < scratch.partners.size(); ++i) {
    scratch.partners[i] = static_cast<std::uint32_t>(i * sampled / scratch.partners.size());
  }
  scratch.counts.resize(scratch.partners.size());
  length_consistency_counts(scratch.sample.view(), scratch.partners, bound_, scratch.counts);
  const auto best = std::max_element(scratch.counts.begin(), scratch.counts.end());
  const std::uint32_t partner = scratch.partners[static_cast<std::size_t>(best - scratch.counts.begin())];
  return {static_cast<float>(*best) * static_cast<float>(scratch.members.size()) / static_cast<float>(sampled),
          window.row(scratch.sampled[partner])};
}

// The rows that agree with the seed and, if they are more than `second_point`, with its partner.
void SampledSets::agreeing_rows(std::uint32_t seed, std::uint32_t partner, std::uint32_t second_point, Scratch& scratch,
                                std::vector<std::uint32_t>& set) const {
  const std::size_t words = correspondences_.view().words();
  const std::uint32_t pair[] = {seed, partner};
  std::uint32_t counts[2];
  scratch.bits.resize(2 * words);
  length_consistency_bits(correspondences_, pair, bound_, scratch.bits, counts);
  const std::span<std::uint64_t> bits = std::span(scratch.bits).first(words);
  if (counts[0] > second_point) intersect(bits, std::span(scratch.bits).last(words), bits);
  members_of(bits, set);
}

void SampledSets::prune(std::uint32_t seed, std::uint32_t partner, std::uint32_t wanted, bool glance,
                        const TcfTuning& tuning, std::vector<std::uint32_t>& set) {
  Scratch& scratch = scratch_.local();
  agreeing_rows(seed, partner, tuning.two_point.second_point, scratch, set);
  const auto size = static_cast<double>(set.size());
  thin(set, tuning.two_point.largest_set);
  const double share = static_cast<double>(set.size()) / size;
  if (glance) {
    scratch.sampled.assign({seed, partner});
    scratch.sampled.insert(scratch.sampled.end(), set.begin(), set.end());
    const float score =
        score_at_a_glance(correspondences_, scratch.sampled, 0.5 * bound_, tuning.two_point.glances, scratch.poses);
    if (!(score > tuning.two_point.glance_share * (share * wanted))) {
      set.clear();
      return;
    }
  }
  scratch.pruner.prune(correspondences_, set, bound_, wanted_of_part(share, wanted, tuning.two_point), tuning.pruning);
}

}  // namespace consimd::detail
