// Correspondences of points as a caller has them: ranges of structs or small arrays, and Eigen's matrices.
#pragma once

#include <Eigen/Core>

#include <concepts>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/point_ranges.hpp>
#include <consimd/poses/eigen_points.hpp>

namespace CONSIMD_EXPORT consimd {

/// A matrix, map, block or reference of Eigen's.
template <typename Points>
concept EigenMatrix = std::derived_from<Points, Eigen::DenseBase<Points>>;

/// The points as they are, not copied: a `PointSpan` itself; a contiguous range as `range_points` takes it; a matrix of
/// Eigen's with three rows as `column_points`, with three columns as `row_points` takes it. Throws
/// std::invalid_argument on a matrix of another shape, and on one of 3 x 3 whose type does not tell.
template <typename Points>
[[nodiscard]] auto points_of(const Points& points) {
  if constexpr (std::same_as<Points, PointSpan<float>> || std::same_as<Points, PointSpan<double>>) {
    return points;
  } else if constexpr (!EigenMatrix<Points>) {
    return range_points(points);
  } else if constexpr (Points::RowsAtCompileTime == 3 && Points::ColsAtCompileTime != 3) {
    return column_points(points);
  } else if constexpr (Points::ColsAtCompileTime == 3 && Points::RowsAtCompileTime != 3) {
    return row_points(points);
  } else {
    if ((points.rows() == 3) != (points.cols() == 3)) {
      return points.rows() == 3 ? column_points(points) : row_points(points);
    }
    throw std::invalid_argument("points have " + std::to_string(points.rows()) + " x " + std::to_string(points.cols()) +
                                " coordinates, expected 3 x N or N x 3; column_points and row_points tell which");
  }
}

/// The correspondences (source[k], target[k]), copied. Throws std::invalid_argument as `points_of` and Correspondences
/// do.
template <typename Source, typename Target>
[[nodiscard]] Correspondences point_pairs(const Source& source, const Target& target) {
  static_assert(std::same_as<decltype(points_of(source)), decltype(points_of(target))>,
                "the coordinates of both are float, or those of both are double");
  return Correspondences(points_of(source), points_of(target));
}

}  // namespace consimd
