#include "search/seed_sets.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>

#include <consimd/kernels/consistency_matrix.hpp>

#include "call/stage_clock.hpp"

namespace consimd::detail {

SeedSets::SeedSets(const Correspondences& correspondences, double consistency_bound, std::uint64_t seed,
                   std::size_t matrix_budget_bytes, const TcfTuning& tuning)
    : correspondences_(correspondences),
      matrix_budget_bytes_(matrix_budget_bytes),
      tuning_(tuning),
      window_(correspondences, seed),
      sampled_(correspondences, consistency_bound),
      matrix_(consistency_bound) {}

void SeedSets::start_over(const TcfTuning& tuning) {
  drawn_ = 0;
  tuning_ = tuning;
}

// Rows of the largest matrix that is useful and fits the budget; 0 when none is.
std::size_t SeedSets::matrix_size() const {
  const std::size_t total = correspondences_.size();
  const std::size_t least = std::min(total, tuning_.window.least_matrix);
  std::size_t size = std::min(total, tuning_.window.largest_matrix);
  while (size >= least && ConsistencyMatrix::memory_bytes(size) > matrix_budget_bytes_) size -= 1 + size / 16;
  return size >= least ? size : 0;
}

double SeedSets::share() const {
  if (counts_.empty()) return 0.0;
  return static_cast<double>(std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0})) /
         static_cast<double>(counts_.size() * window_.size());
}

std::size_t SeedSets::window_size(double share) const {
  const std::size_t size = correspondences_.size();
  const WindowTuning& tuning = tuning_.window;
  const double wanted = share > 0.0 ? std::min(tuning.shown / share, static_cast<double>(size))
                                    : static_cast<double>(std::min(tuning.first, size));
  const auto current = static_cast<double>(window_.size());
  if (wanted < tuning.slack * current && current < tuning.slack * wanted) return window_.size();
  const std::size_t words = (static_cast<std::size_t>(wanted) + kBlock - 1) / kBlock;
  return std::min(words * kBlock, size);
}

void SeedSets::draw(std::uint32_t count, bool dense_work) {
  const StageClock clock(one_point_seconds_);
  const double share = this->share();
  const bool dense = share > tuning_.window.dense;
  first_ = drawn_;
  drawn_ += count;
  counts_.resize(count);
  sets_.resize(std::max<std::size_t>(sets_.size(), count));
  by_matrix_ = (by_matrix_ || (dense && dense_work)) && matrix_size() > 0;
  window_.move(first_, drawn_, by_matrix_ ? matrix_size() : window_size(share));
  if (by_matrix_) {
    matrix_.draw(window_, in_window(0), counts_);
  } else {
    sampled_.draw(window_, in_window(0), counts_);
  }
}

// With a large support found, the usual set may be that of an inlier.
bool SeedSets::outliers_are_usual(std::uint32_t support) const {
  return support < correspondences_.size() / tuning_.two_point.many_inliers;
}

// `small`: sets of up to so many rows in the window, but of more than `least_count`, were not looked at.
void SeedSets::learn_usual_guess(double least_count, float small) {
  unusual_guess_ = 0.0F;
  if (by_matrix_ || tuning_.two_point.unusual == 0.0) return;
  const auto share = static_cast<float>(window_.share());
  for (std::size_t h = 0; h < counts_.size(); ++h) {
    const auto size = static_cast<float>(counts_[h]);
    if (guesses_[h].clique > 0.0F) {
      all_guesses_.push_back(guesses_[h].clique);
    } else if (size > least_count && size < small) {
      all_guesses_.push_back(size / share);
    }
  }
  const auto rank = static_cast<std::size_t>(tuning_.two_point.unusual * static_cast<double>(all_guesses_.size()));
  const auto quantile = all_guesses_.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(all_guesses_.begin(), quantile, all_guesses_.end());
  if (quantile != all_guesses_.end()) unusual_guess_ = *quantile;
}

std::span<const std::uint32_t> SeedSets::rank(std::uint32_t support_to_beat, const Skip& skip) {
  const StageClock clock(two_point_seconds_);
  const TwoPointTuning& tuning = tuning_.two_point;
  const std::uint32_t count = drawn_ - first_;
  // Supporters of a pose within the noise bound are pairwise consistent: a set holds the clique or is too small for it.
  const double share = window_.share();
  const auto largest = static_cast<double>(std::ranges::max(counts_));
  largest_raw_set_ = std::max(largest_raw_set_, static_cast<std::size_t>(largest / share));
  const double least_count = (share < 1.0 ? tuning.support_slack * share : 1.0) * support_to_beat;
  // A set no larger than what stood out so far cannot stand out.
  const float small = outliers_are_usual(support_to_beat) ? unusual_guess_ * static_cast<float>(share) : 0.0F;
  guesses_.assign(count, {});
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 4), [&](const auto& range) {
    for (std::uint32_t h = range.begin(); h < range.end(); ++h) {
      const auto size = static_cast<float>(counts_[h]);
      if (counts_[h] < 3 || size <= least_count || size < small || skip(seed_row(h))) continue;
      guesses_[h] = by_matrix_ ? matrix_.guess(window_, h, tuning) : sampled_.guess(window_, h, tuning);
      guesses_[h].clique /= static_cast<float>(share);
    }
  });
  learn_usual_guess(least_count, small);
  const float best = std::ranges::max_element(guesses_, {}, &SetGuess::clique)->clique;
  const float least = std::max({tuning.slack * best, tuning.support_slack * static_cast<float>(support_to_beat), 3.0F});
  ranking_.clear();
  for (std::uint32_t h = 0; h < count; ++h) {
    if (guesses_[h].clique >= least) ranking_.push_back(h);
  }
  std::ranges::stable_sort(ranking_, std::greater<>(), [&](std::uint32_t h) { return guesses_[h].clique; });
  return ranking_;
}

std::span<const std::uint32_t> SeedSets::promising(std::span<const std::uint32_t> ranking,
                                                   std::uint32_t support_to_beat, const Skip& skip) {
  const float least = std::max(tuning_.two_point.support_slack * static_cast<float>(support_to_beat),
                               outliers_are_usual(support_to_beat) ? unusual_guess_ : 0.0F);
  promising_.clear();
  std::ranges::copy_if(ranking, std::back_inserter(promising_),
                       [&](std::uint32_t h) { return guesses_[h].clique >= least && !skip(seed_row(h)); });
  ranking_.swap(promising_);
  return ranking_;
}

void SeedSets::prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat, bool settled) {
  const StageClock clock(two_point_seconds_);
  const std::uint32_t wanted = std::max(support_to_beat + 1, 3U);
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    const std::uint32_t position = positions[i];
    if (by_matrix_) {
      matrix_.prune(window_, position, wanted, tuning_, sets_[position]);
    } else {
      sampled_.prune(seed_row(position), guesses_[position].partner, wanted, settled, tuning_, sets_[position]);
    }
  });
}

}  // namespace consimd::detail
