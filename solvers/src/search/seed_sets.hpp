// One- and two-point part of the default TCF: seeds and their pruned consensus sets.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "search/matrix_sets.hpp"
#include "search/sampled_sets.hpp"
#include "search/seed_window.hpp"
#include "search/set_guess.hpp"
#include "search/tcf_tuning.hpp"

namespace consimd::detail {

/// Draws correspondences as seeds in a random order without repetition and reduces the set of those consistent with a
/// seed to the members that agree with one another. One object per registration; its memory is reused from round to
/// round.
///
/// What a set may hold is judged by its part in a window: as many rows, the next in the order of the seeds, as show
/// enough of it. Only sets that promise something are looked up among all rows. Where sets are dense the matrix of a
/// window takes the place of both.
class SeedSets {
 public:
  /// Keeps a reference to the correspondences.
  SeedSets(const Correspondences& correspondences, double consistency_bound, std::uint64_t seed,
           std::size_t matrix_budget_bytes, const TcfTuning& tuning);

  /// Tests the next `count` seeds against the window. `dense_work`: enough seeds are still to come that the matrix of
  /// a window pays where sets are dense.
  void draw(std::uint32_t count, bool dense_work);

  /// Draws the same seeds again, with another tuning.
  void start_over(const TcfTuning& tuning);

  /// Whether a seed, a row, need not be looked at.
  using Skip = std::function<bool(std::uint32_t)>;

  /// Positions in the round, most promising first, of the seeds whose sets may hold a clique of more than
  /// `support_to_beat`, without those to skip.
  [[nodiscard]] std::span<const std::uint32_t> rank(std::uint32_t support_to_beat, const Skip& skip);

  /// What still promises more than `support_to_beat` in `ranking` (a tail of what `rank` gave) and need not be skipped.
  [[nodiscard]] std::span<const std::uint32_t> promising(std::span<const std::uint32_t> ranking,
                                                         std::uint32_t support_to_beat, const Skip& skip);

  /// Prunes the sets of the given positions of the round, in parallel; sets that turn out too small come back empty.
  /// `settled`: only rivals of a pose that is hardly doubtful are looked for, so that a glance at a set's poses comes
  /// first.
  void prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat, bool settled);

  /// The set of a position after `prune`: rows, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& set(std::uint32_t position) const { return sets_[position]; }

  [[nodiscard]] std::uint32_t drawn() const noexcept { return drawn_; }
  /// The share of the pairs tested last that is consistent; it is 0 before the first round.
  [[nodiscard]] double share() const;
  /// The size of the largest set before pruning, as far as the window tells.
  [[nodiscard]] std::size_t largest_raw_set() const noexcept { return largest_raw_set_; }
  [[nodiscard]] double one_point_seconds() const noexcept { return one_point_seconds_; }
  [[nodiscard]] double two_point_seconds() const noexcept { return two_point_seconds_; }

 private:
  [[nodiscard]] std::size_t matrix_size() const;
  [[nodiscard]] std::size_t window_size(double share) const;
  [[nodiscard]] std::uint32_t in_window(std::uint32_t position) const { return first_ - window_.first() + position; }
  [[nodiscard]] std::uint32_t seed_row(std::uint32_t position) const { return window_.row(in_window(position)); }
  [[nodiscard]] bool outliers_are_usual(std::uint32_t support) const;
  void learn_usual_guess(double least_count, float small);

  const Correspondences& correspondences_;
  std::size_t matrix_budget_bytes_;
  TcfTuning tuning_;
  SeedWindow window_;
  SampledSets sampled_;
  MatrixSets matrix_;
  bool by_matrix_ = false;   // which of the two has the round's sets
  std::uint32_t first_ = 0;  // the round's seeds are those of places first_ to drawn_ - 1 of the order
  std::uint32_t drawn_ = 0;
  std::vector<std::uint32_t> counts_;  // of the rows in the window that agree with each of the round's seeds
  std::vector<SetGuess> guesses_;
  std::vector<float> all_guesses_;  // of all rounds, in no order
  float unusual_guess_ = 0.0F;      // quantile of them above which a seed stands out; 0 where sets are not sampled
  std::vector<std::uint32_t> ranking_;
  std::vector<std::uint32_t> promising_;
  std::vector<std::vector<std::uint32_t>> sets_;
  std::size_t largest_raw_set_ = 0;
  double one_point_seconds_ = 0.0;
  double two_point_seconds_ = 0.0;
};

}  // namespace consimd::detail
