// Angle consistency: the two-point consensus test of TCF, Eq. (alpha-angle) and (beta-2pt).
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// Correspondence m is angle consistent with the pair (i, j) when the angle at m is the same in both clouds up to
/// noise:
///   | angle(p_i p_m p_j) - angle(q_i q_m q_j) | < asin(bound / |p_m - p_i|) + asin(bound / |p_m - p_j|),
/// the rotation-invariant reading of the paper's Eq. (alpha-angle). The paper's bound is tau, its authors' code uses 2
/// tau. Where a distance to p_m is not above the bound the arcsine is undefined and the angle carries no information: m
/// is consistent.
///
/// The kernels use an equivalent form without trigonometry. Call the two angles a and b, the sum of the arcsines g: |a
/// - b| < g holds when
///   (cos b - cos a cos g)^2 < sin(a)^2 sin(g)^2,
/// which is cos(a + g) < cos b < cos(a - g), and also where one of these limits is past its pole: a < g has no upper
/// limit for cos b, a > pi - g no lower one. With x1 = p_i - p_m, x2 = p_j - p_m, y1, y2 likewise in the target, B =
/// bound^2,
///   X = |x1|^2 |x2|^2, U = 2 x1.x2, Y = |y1|^2 |y2|^2, V = 2 y1.y2, S = |x1|^2 + |x2|^2,
///   c = sqrt((|x1|^2 - B) (|x2|^2 - B)) - B = |x1| |x2| cos g,     |x1|^2 |x2|^2 sin(g)^2 = B (S + 2 c),
///   F = V X - U c sqrt(Y):     consistent  <=>  F^2 < (4 X - U^2) (S + 2 c) B Y   or   2 c |F| < F U,
/// with U and V by the law of cosines from the squared sides. Near the threshold F is a difference of the size of its
/// limit, so single precision resolves angles down to its rounding, not down to the root of it as a comparison of
/// cosines would. `bound` is in the caller's unit, finite and > 0.

/// counts[s] = number of m consistent with pairs[s]. pairs: S, indices below view.size(); counts: S.
/// Throws std::invalid_argument on mismatched sizes or a bad bound, std::out_of_range on a bad index.
void angle_consistency_counts(const CorrespondenceView& view, std::span<const IndexPair> pairs, double bound,
                              std::span<std::uint32_t> counts);

/// As above, with the bits: S rows of view.words() words, laid out as in `length_consistency_bits`.
void angle_consistency_bits(const CorrespondenceView& view, std::span<const IndexPair> pairs, double bound,
                            std::span<std::uint64_t> bits, std::span<std::uint32_t> counts);

}  // namespace consimd
