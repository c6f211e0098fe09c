// Consensus sets of single seeds, judged by samples of them and pruned by matrices of their own.
#pragma once

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "search/pruning.hpp"
#include "search/seed_window.hpp"
#include "search/set_guess.hpp"
#include "search/set_poses.hpp"
#include "search/tcf_tuning.hpp"

namespace consimd::detail {

/// One object per registration; its memory is reused from round to round.
class SampledSets {
 public:
  /// Keeps a reference to the correspondences.
  SampledSets(const Correspondences& correspondences, double consistency_bound);

  /// Tests the `sizes.size()` seeds from row `begin` of the window on against the window: how many rows agree with
  /// each.
  void draw(const SeedWindow& window, std::uint32_t begin, std::span<std::uint32_t> sizes);

  /// A two-point hypothesis (seed, partner) for the price of a few hundred pairs: the largest clique through the seed
  /// is guessed from a sample of its set in the window, as the best partner's consensus within it.
  [[nodiscard]] SetGuess guess(const SeedWindow& window, std::uint32_t position, const TwoPointTuning& tuning);

  /// The set among all rows of the seed and, if it is large, of its partner as well, thinned and pruned; empty if it
  /// turns out too small for `wanted`. `glance`: or if a glance at its poses promises no such support.
  void prune(std::uint32_t seed, std::uint32_t partner, std::uint32_t wanted, bool glance, const TcfTuning& tuning,
             std::vector<std::uint32_t>& set);

 private:
  struct Scratch {
    SetPruner pruner;
    PoseScratch poses;
    Correspondences sample;
    std::vector<std::uint32_t> members;
    std::vector<std::uint32_t> sampled;
    std::vector<std::uint32_t> partners;
    std::vector<std::uint64_t> bits;
    std::vector<std::uint32_t> counts;
  };

  void agreeing_rows(std::uint32_t seed, std::uint32_t partner, std::uint32_t second_point, Scratch& scratch,
                     std::vector<std::uint32_t>& set) const;

  const Correspondences& correspondences_;
  double bound_;
  std::uint32_t begin_ = 0;           // the round's first seed, within the window
  std::vector<std::uint32_t> seeds_;  // of the round, within the window
  std::vector<std::uint64_t> bits_;   // rows of the round's seeds over the window
  tbb::enumerable_thread_specific<Scratch> scratch_;
};

}  // namespace consimd::detail
