// Sets of rows that agree in length pairwise, where few pairs of rows do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace consimd::detail {

/// The time that looking at all sets takes, in that of a seed: of `rows`, of whose pairs this share agrees. Infinite
/// unless these are sparse: two rows that agree have few others in common, so that hardly any set lasts by chance, and
/// the matrix fits the budget.
[[nodiscard]] double seeds_for_all_sets(std::size_t rows, double share, std::size_t matrix_budget_bytes);

/// How many rows agree pairwise by chance, where each pair does with the chance `share`: more make less than one set.
[[nodiscard]] std::uint32_t largest_by_chance(std::size_t rows, double share);

struct SparseSets {
  std::vector<std::vector<std::uint32_t>> sets;  ///< rows ascending; large sets first
  bool all = false;                              ///< none was missed; otherwise there are none
  std::uint32_t least = 0;                       ///< rows of those that were looked for, or more
};

/// For each row a largest set of `least` or more rows, and of more than agree by chance, of which it comes first, in an
/// order of the rows, and which agree with one another to within `bound` (caller's unit). Every set that agrees is a
/// part of one, or no larger than one that begins with the same row. Needs the memory of a ConsistencyMatrix. Gives up
/// if `stop` is met or a row has too many sets to look at, as in clusters of rows that all agree.
[[nodiscard]] SparseSets sparse_sets(const Correspondences& correspondences, double bound, std::uint32_t least,
                                     const StopCondition& stop);

}  // namespace consimd::detail
