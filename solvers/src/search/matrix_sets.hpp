// Consensus sets by the consistency matrix of a window, which serves every seed of it: for sets so dense that samples
// tell too little.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>

#include "search/pruning.hpp"
#include "search/seed_window.hpp"
#include "search/set_guess.hpp"
#include "search/tcf_tuning.hpp"

namespace consimd::detail {

/// One object per registration; its memory is reused from round to round.
class MatrixSets {
 public:
  explicit MatrixSets(double consistency_bound) : bound_(consistency_bound) {}

  /// How many rows of the window agree with each of the `sizes.size()` seeds from row `begin` of it on.
  void draw(const SeedWindow& window, std::uint32_t begin, std::span<std::uint32_t> sizes);

  /// What the best of a few second points has in common with the seed beyond chance.
  [[nodiscard]] SetGuess guess(const SeedWindow& window, std::uint32_t position, const TwoPointTuning& tuning);

  /// The set of a position of the round within the window, pruned by what its members agree with beyond chance; rows of
  /// all, ascending. Empty if it turns out too small for `wanted` members among all rows.
  void prune(const SeedWindow& window, std::uint32_t position, std::uint32_t wanted, const TcfTuning& tuning,
             std::vector<std::uint32_t>& set);

 private:
  struct Scratch {
    PruneScratch prune;
    std::vector<std::uint32_t> partners;
    std::vector<std::uint32_t> counts;
  };

  double bound_;
  std::uint32_t begin_ = 0;  // the round's first seed, within the window
  std::uint32_t window_first_ = 0;
  ConsistencyMatrix matrix_;  // of the window that begins there
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace consimd::detail
