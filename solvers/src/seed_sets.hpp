// One- and two-point part of the default TCF: seeds and their pruned consensus sets.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>

#include "pruning.hpp"

namespace consimd::detail {

/// Draws correspondences as seeds in a random order without repetition and reduces the set of those consistent with a
/// seed to the members that agree with one another. One object per registration; its memory is reused from round to
/// round.
class SeedSets {
 public:
  SeedSets(const Correspondences& correspondences, double consistency_bound, std::uint64_t seed,
           std::size_t matrix_budget_bytes);

  /// Computes the raw consensus sets of the next `count` seeds. `dense_work`: enough seeds are still to come that the
  /// matrix of all correspondences pays where sets are dense.
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
  void prune(std::span<const std::uint32_t> positions, std::uint32_t support_to_beat);

  /// The set of a position after `prune`: rows, ascending.
  [[nodiscard]] const std::vector<std::uint32_t>& set(std::uint32_t position) const { return sets_[position]; }

  [[nodiscard]] std::uint32_t drawn() const noexcept { return drawn_; }
  [[nodiscard]] std::size_t largest_raw_set() const noexcept { return largest_raw_set_; }
  [[nodiscard]] double one_point_seconds() const noexcept { return one_point_seconds_; }
  [[nodiscard]] double two_point_seconds() const noexcept { return two_point_seconds_; }

 private:
  struct Scratch {
    SetPruner set_pruner;
    PruneScratch matrix_prune;
    Correspondences sample;
    std::vector<std::uint32_t> members;
    std::vector<std::uint32_t> sampled;
    std::vector<std::uint32_t> partners;
    std::vector<std::uint64_t> bits;
    std::vector<std::uint64_t> partner_bits;
    std::vector<std::uint32_t> counts;
  };

  struct Guess {
    float clique;           // size of the largest clique through the seed
    std::uint32_t partner;  // row that tells
  };

  [[nodiscard]] std::span<const std::uint64_t> row(std::uint32_t position) const;
  [[nodiscard]] Guess guess(std::uint32_t position, Scratch& scratch) const;
  [[nodiscard]] float clique_by_matrix(std::uint32_t position, Scratch& scratch) const;

  const Correspondences& correspondences_;
  double bound_;
  std::uint64_t seed_;
  std::size_t matrix_budget_bytes_;
  std::vector<std::uint32_t> order_;  // a random permutation of all rows, final up to shuffled_
  std::uint32_t shuffled_ = 0;
  std::uint32_t drawn_ = 0;
  bool careful_ = false;
  std::span<const std::uint32_t> round_;  // the seeds of the round, within order_
  ConsistencyMatrix matrix_;              // of all correspondences; empty until it pays
  std::vector<std::uint64_t> bits_;       // rows of the round's seeds, when there is no matrix
  std::vector<std::uint32_t> counts_;
  std::vector<float> estimates_;
  std::vector<std::uint32_t> partners_;
  std::vector<float> all_estimates_;  // of all rounds, in no order
  float usual_estimate_ = 0.0F;       // their median; 0 where sets are not sampled
  std::vector<std::uint32_t> ranking_;
  std::vector<std::uint32_t> promising_;
  std::vector<std::vector<std::uint32_t>> sets_;
  tbb::enumerable_thread_specific<Scratch> scratch_;
  std::size_t largest_raw_set_ = 0;
  double one_point_seconds_ = 0.0;
  double two_point_seconds_ = 0.0;
};

}  // namespace consimd::detail
