// Points near a point, and the axes along which they spread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/point_run.hpp>

namespace CONSIMD_EXPORT consimd {

/// What `neighbours_within` may write beyond the points of its runs.
inline constexpr std::size_t kNeighbourSlack = 16;

/// Finds the points p of the runs with |p - query|^2 <= radius^2, in the order of the runs.
/// query: in the working frame. radius: in the caller's unit, finite and > 0. indices, squared_distances: room for all
/// points of the runs and kNeighbourSlack more; what lies beyond the result is overwritten. squared_distances: of the
/// working frame. Returns the number of points found. Throws std::invalid_argument on a bad radius or too little room,
/// std::out_of_range on a run beyond the cloud.
std::size_t neighbours_within(const CloudView& cloud, const std::array<float, 3>& query, std::span<const PointRun> runs,
                              double radius, std::span<std::uint32_t> indices, std::span<float> squared_distances);

/// Finds the points p of the runs nearest to `query`, at most as many as `indices` has room for, among those with |p -
/// query|^2 <= radius^2; ascending by distance, equally near ones by index, whatever the order of the runs. query: in
/// the working frame; one with NaN has none. radius: in the caller's unit, finite and > 0. squared_distances: of the
/// working frame, as long as `indices`; what lies beyond the result keeps its value. Returns the number of points
/// found. Throws std::invalid_argument on a bad radius, no room or unequal lengths, std::out_of_range on a run beyond
/// the cloud.
std::size_t nearest_within(const CloudView& cloud, const std::array<float, 3>& query, std::span<const PointRun> runs,
                           double radius, std::span<std::uint32_t> indices, std::span<float> squared_distances);

/// sum (p - mean)(p - mean)^T over the points of a neighbourhood, as xx, xy, xz, yy, yz, zz, in units of radius^2.
/// centre: the point, in the working frame, from which offsets are taken before they are rounded and summed. radius: in
/// the caller's unit. Throws std::invalid_argument without indices or on a bad radius, std::out_of_range on a bad
/// index.
[[nodiscard]] std::array<float, 6> neighbourhood_scatter(const CloudView& cloud, const std::array<float, 3>& centre,
                                                         std::span<const std::uint32_t> indices, double radius);

/// Symmetric 3 x 3 matrices side by side: entry (xx, xy, xz, yy, yz, zz), matrix.
struct alignas(64) ScatterBatch {
  static constexpr std::size_t kSize = 64;
  float entries[6][kSize];
};

/// Their eigenvalues, ascending, and the unit eigenvectors of the smallest ones: axis, matrix.
struct alignas(64) PrincipalAxes {
  float values[3][ScatterBatch::kSize];
  float smallest_axes[3][ScatterBatch::kSize];
};

/// Eigenvalues and smallest axes of the first `n` matrices by Jacobi's method, four sweeps, which leaves errors of a
/// few roundings of the largest entry. The sign of an axis is any. Of matrices that are not finite the result is of no
/// use. n <= ScatterBatch::kSize; what lies beyond may be overwritten. Throws std::invalid_argument on a larger one.
void principal_axes(const ScatterBatch& scatter, std::size_t n, PrincipalAxes& axes);

}  // namespace consimd
