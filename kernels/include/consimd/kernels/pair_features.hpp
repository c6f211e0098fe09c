// Histograms of the features of point pairs: what FPFH descriptors are made of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Bins of the three features together, eleven each.
inline constexpr std::size_t kPairFeatureBins = 33;
/// Floats from one histogram to the next in a table of them.
inline constexpr std::size_t kHistogramStride = 48;

/// Features of a pair of points with unit normals (Rusu, Blodow, Beetz, "Fast point feature histograms (FPFH) for 3D
/// registration", ICRA 2009), d the line from the source s to the target t, in the frame u = n_s, v = d x u / |d x u|,
/// w = u x v:
///   atan2(w . n_t, u . n_t) in [-pi, pi],  v . n_t in [-1, 1],  u . d / |d| in [-1, 1].
/// The source is the end whose normal is nearer to the line through both, the given point where they are equally near.
/// Each range has 11 equal bins. Features are compared with the bins' borders by squares and cross products: there is
/// no arc tangent, and no root but one.

/// counts[11 f + b]: how many pairs of `point` and one of `indices` have feature f in bin b. A pair of no length, of a
/// line along the source's normal, or without a normal is not counted.
/// Throws std::invalid_argument where the cloud has no normals, std::out_of_range on a bad index.
void pair_feature_counts(const CloudView& cloud, std::uint32_t point, std::span<const std::uint32_t> indices,
                         std::span<std::uint32_t, kPairFeatureBins> counts);

/// sum over j of histogram rows[j] / squared_distances[j], in order, but of those with a distance of 0.
/// histograms: a table of kHistogramStride floats a row, aligned to 64 bytes; sum: aligned likewise. Throws
/// std::invalid_argument on sizes or alignments that do not fit, std::out_of_range on a bad row.
void weighted_histogram_sum(std::span<const float> histograms, std::span<const std::uint32_t> rows,
                            std::span<const float> squared_distances, std::span<float, kHistogramStride> sum);

}  // namespace consimd
