// One- and two-point part of the default TCF: seeds and their pruned consensus sets.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>

#include "sampling/counter_random.hpp"
#include "search/pruning.hpp"
#include "search/set_poses.hpp"

namespace consimd::detail {

/// Draws correspondences as seeds in a random order without repetition and reduces the set of those consistent with a
/// seed to the members that agree with one another. One object per registration; its memory is reused from round to
/// round.
///
/// What a set may hold is judged by its part in a window: as many rows, the next in the order of the seeds, as show
/// enough of it. Only sets that promise something are looked up among all rows.
class SeedSets {
 public:
  SeedSets(const Correspondences& correspondences, double consistency_bound, std::uint64_t seed,
           std::size_t matrix_budget_bytes);

  /// Tests the next `count` seeds against the window. `dense_work`: enough seeds are still to come that the matrix of
  /// a window pays where sets are dense.
  void draw(std::uint32_t count, bool dense_work);

  /// Draws the same seeds again, but keeps sets whole and drops none for what a sample of it says.
  void start_over_carefully();

  /// Whether a seed, a row, need not be looked at.
  using Skip = std::function<bool(std::uint32_t)>;

  /// Positions in the round, most promising first, of the seeds whose sets may hold a clique of more than
  /// `support_to_beat`, without those to skip.
  [[nodiscard]] std::span<const std::uint32_t> rank(std::uint32_t support_to_beat, const Skip& skip);

  /// Of `ranking` (a tail of what `rank` gave), what still promises more than `support_to_beat` and need not be
  /// skipped.
  [[nodiscard]] std::span<const std::uint32_t> promising(std::span<const std::uint32_t> ranking,
                                                         std::uint32_t support_to_beat, const Skip& skip);

  /// Prunes the sets of the given positions of the round, in parallel; sets that turn out too small come back empty.
  /// `settled`: only rivals of a pose that is hardly doubtful are looked for, so that a glance at a set's poses comes
  /// first.
  void prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat, bool settled);

  /// The set of a position after `prune`: rows, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& set(std::uint32_t position) const { return sets_[position]; }

  [[nodiscard]] std::uint32_t drawn() const noexcept { return drawn_; }
  /// The size of the largest set before pruning, as far as the window tells.
  [[nodiscard]] std::size_t largest_raw_set() const noexcept { return largest_raw_set_; }
  [[nodiscard]] double one_point_seconds() const noexcept { return one_point_seconds_; }
  [[nodiscard]] double two_point_seconds() const noexcept { return two_point_seconds_; }

 private:
  struct Scratch {
    SetPruner set_pruner;
    PruneScratch matrix_prune;
    PoseScratch poses;
    Correspondences sample;
    std::vector<std::uint32_t> members;
    std::vector<std::uint32_t> sampled;
    std::vector<std::uint32_t> partners;
    std::vector<std::uint64_t> bits;
    std::vector<std::uint32_t> counts;
  };

  struct Guess {
    float clique = 0.0F;        // size of the largest clique through the seed
    std::uint32_t partner = 0;  // row that tells
  };

  void move_window(std::size_t size);
  [[nodiscard]] std::size_t matrix_size() const;
  [[nodiscard]] std::size_t window_size(double share) const;
  [[nodiscard]] double window_share() const;
  [[nodiscard]] std::uint32_t window_row(std::uint32_t i) const { return order_[window_first_ + i]; }
  [[nodiscard]] std::uint32_t seed_row(std::uint32_t position) const { return order_[first_ + position]; }
  [[nodiscard]] bool outliers_are_usual(std::uint32_t support) const;
  [[nodiscard]] std::span<const std::uint64_t> bits_of(std::uint32_t position) const;
  [[nodiscard]] Guess guess(std::uint32_t position, Scratch& scratch) const;
  [[nodiscard]] Guess guess_by_matrix(std::uint32_t position, Scratch& scratch) const;
  void two_point_set(std::uint32_t position, Scratch& scratch, std::vector<std::uint32_t>& set) const;
  [[nodiscard]] bool promises_pose(std::uint32_t position, std::span<const std::uint32_t> set, double wanted,
                                   Scratch& scratch) const;

  const Correspondences& correspondences_;
  double bound_;
  std::size_t matrix_budget_bytes_;
  CounterRandom random_;              // shuffles
  std::vector<std::uint32_t> order_;  // a random permutation of all rows, final up to shuffled_
  std::uint32_t shuffled_ = 0;
  std::uint32_t first_ = 0;  // the round's seeds are order_[first_] to order_[drawn_ - 1]
  std::uint32_t drawn_ = 0;
  bool careful_ = false;
  Correspondences window_;  // rows order_[window_first_] and following
  std::uint32_t window_first_ = 0;
  bool by_matrix_ = false;
  ConsistencyMatrix matrix_;          // of the window, if by_matrix_
  std::vector<std::uint32_t> seeds_;  // of the round, within the window
  std::vector<std::uint64_t> bits_;   // rows of the round's seeds over the window, if not
  std::vector<std::uint32_t> counts_;
  std::vector<Guess> guesses_;
  std::vector<float> all_guesses_;  // of all rounds, in no order
  float unusual_guess_ = 0.0F;      // quantile of them above which a seed stands out; 0 where sets are not sampled
  std::vector<std::uint32_t> ranking_;
  std::vector<std::uint32_t> promising_;
  std::vector<std::vector<std::uint32_t>> sets_;
  tbb::enumerable_thread_specific<Scratch> scratch_;
  std::size_t largest_raw_set_ = 0;
  double one_point_seconds_ = 0.0;
  double two_point_seconds_ = 0.0;
};

}  // namespace consimd::detail
