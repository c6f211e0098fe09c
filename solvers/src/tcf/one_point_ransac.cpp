#include <consimd/solvers/one_point_ransac.hpp>

#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <numeric>

#include <consimd/kernels/length_consistency.hpp>

#include "bits/bit_rows.hpp"
#include "call/option_checks.hpp"
#include "sampling/sampling.hpp"
#include "search/pruning.hpp"

namespace consimd {

ConsensusSet one_point_ransac(const Correspondences& correspondences, const OnePointOptions& options) {
  detail::require_length("consistency_bound", options.consistency_bound);
  detail::require_confidence(options.confidence);
  ConsensusSet best;
  const auto size = static_cast<std::uint32_t>(correspondences.size());
  if (size == 0) return best;

  const CorrespondenceView view = correspondences.view();
  const std::size_t words = view.words();
  std::vector<std::uint32_t> seeds(detail::kBatch);
  std::vector<std::uint32_t> counts(detail::kBatch);
  std::vector<std::uint64_t> bits(detail::kBatch * words);
  std::vector<std::vector<std::uint32_t>> sets(detail::kBatch);
  tbb::enumerable_thread_specific<detail::SetPruner> pruners;

  std::uint64_t needed = 1;
  while (best.iterations < options.max_iterations && best.iterations <= needed) {
    for (std::uint32_t h = 0; h < detail::kBatch; ++h) {
      seeds[h] = detail::CounterRandom(options.seed, detail::RandomStage::one_point, best.iterations + h).below(size);
    }
    tbb::parallel_for(std::uint32_t{0}, detail::kBatch / 4, [&](std::uint32_t quarter) {
      const std::size_t h0 = quarter * 4;
      length_consistency_bits(view, std::span(seeds).subspan(h0, 4), options.consistency_bound,
                              std::span(bits).subspan(h0 * words, 4 * words), std::span(counts).subspan(h0, 4));
      for (std::size_t h = h0; h < h0 + 4; ++h) {
        sets[h].clear();
        // A set that is smaller than the best pruned one before pruning cannot win.
        if (counts[h] < best.score) continue;
        detail::members_of(std::span(bits).subspan(h * words, words), sets[h]);
        if (options.prune) pruners.local().prune(correspondences, sets[h], options.consistency_bound, best.score);
      }
    });
    for (std::uint32_t h = 0;
         h < detail::kBatch && best.iterations < options.max_iterations && best.iterations <= needed; ++h) {
      ++best.iterations;
      const auto score = static_cast<std::uint32_t>(sets[h].size());
      if (score < best.score) continue;
      best.score = score;
      best.members.swap(sets[h]);
      needed = detail::iterations_needed(options.confidence, static_cast<double>(score) / size, 1);
    }
  }
  return best;
}

}  // namespace consimd
