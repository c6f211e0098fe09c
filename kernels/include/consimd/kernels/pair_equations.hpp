// One step of the iterative closest points: points moved, pairs that hold, the normal equations of the next motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/pair_block.hpp>

namespace CONSIMD_EXPORT consimd {

/// block.points = the motion of block.from, entries 0 to n - 1. Bit i of `stale` (word i / 64) tells that entry i has
/// come as far from where it was looked for as it may be trusted, or further, or is not finite; the other bits are 0.
/// Entries from n on may be overwritten. Distances are lengthened by what rounding may take from them in a frame whose
/// coordinates are at most 1. Throws std::invalid_argument where n is above PairBlock::kSize.
void move_pairs(PairBlock& block, std::size_t n, const WorkingMotion& motion,
                std::span<std::uint64_t, PairBlock::kSize / 64> stale);

/// squared[i] = r^2 of entry i, NaN where it is no pair: further apart than max_distance, without nearest point, or
/// without a normal that the metric needs. squared: n. Throws std::invalid_argument where n is above PairBlock::kSize,
/// on another length of `squared`, and where normals of the target are needed that it has not; std::out_of_range on a
/// row above target.size().
void pair_residuals(const CloudView& target, const PairBlock& block, std::size_t n, const PairProblem& problem,
                    std::span<float> squared);

/// The normal equations of entries 0 to n - 1; what is no pair adds nothing. Sums are taken in 16 interleaved parts,
/// joined pairwise. Throws as `pair_residuals`, and std::invalid_argument unless the scale is 2^-40 or more.
[[nodiscard]] PairEquations pair_equations(const CloudView& target, const PairBlock& block, std::size_t n,
                                           const PairProblem& problem);

}  // namespace consimd
