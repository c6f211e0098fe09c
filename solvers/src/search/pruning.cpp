#include "search/pruning.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace consimd::detail {
namespace {

std::uint32_t ceil_sqrt(std::uint64_t value) {
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(value)));
  while (root * root < value) ++root;
  while (root > 0 && (root - 1) * (root - 1) >= value) --root;
  return static_cast<std::uint32_t>(root);
}

// Smallest degree among the `keep` highest, and how many members of exactly that degree belong to them.
struct Cut {
  std::uint32_t degree;
  std::uint32_t at_degree;
};

Cut cut_for(std::span<const std::uint32_t> degrees, std::uint32_t keep, std::vector<std::uint32_t>& histogram) {
  histogram.assign(degrees.size() + 1, 0);
  for (const std::uint32_t degree : degrees) ++histogram[degree];
  std::uint32_t above = 0;
  auto degree = static_cast<std::uint32_t>(degrees.size());
  while (above + histogram[degree] < keep) above += histogram[degree--];
  return {degree, keep - above};
}

// Takes from each member's degree within the set what its degree in the whole matrix lets expect, down to 0.
void subtract_chance(const ConsistencyMatrix& matrix, std::span<const std::uint32_t> members,
                     std::span<std::uint32_t> degrees) {
  const double share = static_cast<double>(members.size()) / static_cast<double>(matrix.size());
  const std::span<const std::uint32_t> all = matrix.degrees();
  for (std::size_t i = 0; i < members.size(); ++i) {
    degrees[i] -= std::min(degrees[i], static_cast<std::uint32_t>(share * all[members[i]]));
  }
}

}  // namespace

void prune(const ConsistencyMatrix& matrix, std::vector<std::uint32_t>& members, std::uint32_t give_up_below,
           Merit merit, const PruningTuning& tuning, PruneScratch& scratch) {
  for (std::uint32_t round = 0;; ++round) {
    scratch.set.assign(matrix.words(), 0);
    for (const std::uint32_t row : members) scratch.set[row / kBlock] |= std::uint64_t{1} << (row % kBlock);
    scratch.degrees.resize(members.size());
    and_popcount_rows(matrix, scratch.set, members, scratch.degrees);

    std::uint64_t ones = 0;
    for (const std::uint32_t degree : scratch.degrees) ones += degree;
    std::uint32_t keep = ceil_sqrt(ones);
    const auto size = static_cast<std::uint32_t>(members.size());
    // Later rounds may have dropped some of the clique: only the first one can tell.
    if (round == 0 && keep < give_up_below) {
      members.clear();
      return;
    }
    if (keep >= size) break;

    if (merit == Merit::excess) {
      if (size > tuning.large) {
        keep = std::min(keep, std::max(static_cast<std::uint32_t>(tuning.large_kept * keep), give_up_below));
      }
      subtract_chance(matrix, members, scratch.degrees);
    }
    Cut cut = cut_for(scratch.degrees, keep, scratch.histogram);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::uint32_t degree = scratch.degrees[i];
      if (degree > cut.degree || (degree == cut.degree && cut.at_degree > 0)) {
        if (degree == cut.degree) --cut.at_degree;
        members[kept++] = members[i];
      }
    }
    members.resize(kept);
    if (size - keep < tuning.smallest_drop) break;
  }
}

void SetPruner::prune(const Correspondences& correspondences, std::vector<std::uint32_t>& set, double consistency_bound,
                      std::uint32_t give_up_below, const PruningTuning& tuning) {
  subset_.assign_subset(correspondences, set);
  matrix_.compute(subset_.view(), consistency_bound);
  local_.resize(set.size());
  std::iota(local_.begin(), local_.end(), 0U);
  detail::prune(matrix_, local_, give_up_below, Merit::degree, tuning, scratch_);
  for (std::size_t i = 0; i < local_.size(); ++i) set[i] = set[local_[i]];
  set.resize(local_.size());
}

}  // namespace consimd::detail
