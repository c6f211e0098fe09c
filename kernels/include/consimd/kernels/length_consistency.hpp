// Length consistency: the one-point consensus test of TCF, Eq. (consensus-search-1) and (length-consistency).
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Correspondences j and k are length consistent when
///   | |p_j - p_k| - |q_j - q_k| | < bound.
/// The paper's bound is 2 tau, tau the noise bound of one correspondence: two inliers within tau of a common pose
/// always pass.
///
/// The kernels use the equivalent form without square roots: with a = |p_j-p_k|^2, b = |q_j-q_k|^2,
///   (a - b)^2 < max(2 bound^2 (a + b) - bound^4, bound^4).
/// A correspondence is consistent with itself. `bound` is in the caller's unit, finite and > 0.

/// counts[s] = number of j consistent with seeds[s].
/// seeds: S indices below view.size(); counts: S. Throws std::invalid_argument on mismatched sizes or a bad bound,
/// std::out_of_range on a bad index.
void length_consistency_counts(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                               std::span<std::uint32_t> counts);

/// As above, and bit j of row s (S rows of view.words() words, row-major; bit j of word j / 64) tells whether j is
/// consistent with seeds[s]. Bits from view.size() on are 0.
void length_consistency_bits(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                             std::span<std::uint64_t> bits, std::span<std::uint32_t> counts);

}  // namespace consimd
