// Points far from the bulk of their cloud: a map coordinate left in, the -9999 or 1e308 of "no value".
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Rows up to this remoteness make the frame: its centroids and what it resolves.
inline constexpr double kBulk = 32.0;
/// Beyond this remoteness a row is far. The noise of the bulk turns such a point by more than itself, so that no pose
/// of the bulk reconciles it.
inline constexpr double kFar = 256.0;

/// The distance of each row's source or target, whichever is more remote, from the middle of its cloud (coordinate by
/// coordinate the median), in median distances: the half of the points that are close count, at any distance of the
/// others. Distances are largest coordinate differences. A point with three equal coordinates, the "no value" of many
/// rows, counts once, and so do up to three places that half of the other rows of a cloud have. Where other rows keep
/// their distances from one another and these do not, or fewer of them, the middles and the median distances are of the
/// others: of all rows without their copies, of those beyond kBulk, or of the places that these are in. Empty where no
/// row is beyond kBulk, as far as a look at some pairs and at `source_extent` and `target_extent`, the largest
/// distances from the centroids, tells: at ordinary data nothing else is looked at.
template <typename T>
std::vector<double> remoteness(const PointSpan<T>& source, double source_extent, const PointSpan<T>& target,
                               double target_extent);

/// Some rows of points; all of them where `rows` is empty.
template <typename T>
struct ChosenPoints {
  PointSpan<T> points;
  std::span<const std::uint32_t> rows;
  std::size_t size;

  [[nodiscard]] T operator()(std::size_t i, std::size_t axis) const { return points(rows.empty() ? i : rows[i], axis); }
};

/// A point of a cloud beyond this remoteness belongs to no scan: ranges of 2 km beside a median of 2 m are within it. A
/// grid of cells a hundredth of the median distance wide, as clouds are thinned out with, can still number the rest.
inline constexpr double kFarOfCloud = 1024.0;

/// The same of one cloud, whose `extent` is the largest distance from its mean. Empty where no point is beyond
/// kFarOfCloud, or more than a tenth of them are: that is no stray point, but how the cloud is.
template <typename T>
std::vector<double> remoteness(const ChosenPoints<T>& points, double extent);

}  // namespace consimd::detail
