// How the lengths between two correspondences compare: the pairwise measures of PCR-99 and of scale voting.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// With A_j = |p_j - p_i|, B_j = |q_j - q_i| the lengths of a pair, PCR-99 (S. H. Lee, J. Civera, P. Vandewalle) judges
/// it by |ln(B / A)|. Without a logarithm, since tanh(ln(B / A)) = (B^2 - A^2) / (B^2 + A^2):
///   d_ij = |B^2 - A^2| / min(ratio_bound (A^2 + B^2), bound (A + B)),
/// the larger of two shares: that of the ratio's difference from 1 in its bound, tanh of the bound on the logarithm,
/// and that of the lengths' difference |B - A| in its own.
///
/// costs[s] = sum over j of min(d_ij, 1), i = seeds[s]; where both lengths are zero d_ij is 0. Single precision, in 16
/// interleaved sums joined in one order: the same bits on every ISA.
/// seeds: S indices below view.size(); costs: S; bound: caller's unit, finite and > 0; ratio_bound: in (0, 1). Throws
/// std::invalid_argument on mismatched sizes or a bad bound, std::out_of_range on a bad index.
void length_disagreement(const CorrespondenceView& view, std::span<const std::uint32_t> seeds, double bound,
                         double ratio_bound, std::span<float> costs);

/// The scales s with |B_j - s A_j| < bound, those at which j and `seed` are length consistent:
///   lows[j] = max(B_j - bound, 0) / A_j,  highs[j] = (B_j + bound) / A_j,
/// both not finite where A_j is zero, as for the seed itself. lows, highs: view.words() * kBlock floats; those from
/// view.size() on become NaN. Throws as above.
void scale_intervals(const CorrespondenceView& view, std::uint32_t seed, double bound, std::span<float> lows,
                     std::span<float> highs);

}  // namespace consimd
