// Points in Eigen's matrices, maps and blocks, as they are: no copy.
#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <stdexcept>
#include <string>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Points that are the columns of a 3 x N matrix of float or double: Matrix3Xd, a Map or Ref with any strides, the
/// topRows<3>() of homogeneous points. The matrix must outlive the result; a temporary that owns its numbers does not
/// compile, nor does an expression that is yet to be computed. Throws std::invalid_argument when there are not 3 rows.
template <typename Derived>
[[nodiscard]] PointSpan<typename Derived::Scalar> column_points(const Eigen::DenseBase<Derived>& points) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0, "an expression without storage: evaluate it first");
  static_assert(Derived::RowsAtCompileTime == 3 || Derived::RowsAtCompileTime == Eigen::Dynamic, "points are 3 x N");
  const Derived& m = points.derived();
  if (m.rows() != 3) {
    throw std::invalid_argument("points have " + std::to_string(m.rows()) + " x " + std::to_string(m.cols()) +
                                " coordinates, expected 3 x N");
  }
  return {m.data(), static_cast<std::size_t>(m.cols()), m.colStride(), m.rowStride()};
}

template <typename Derived>
void column_points(const Eigen::PlainObjectBase<Derived>&& points) = delete;

/// As above for the rows of an N x 3 matrix, column-major (Eigen's default) or row-major (NumPy's, C's).
template <typename Derived>
[[nodiscard]] PointSpan<typename Derived::Scalar> row_points(const Eigen::DenseBase<Derived>& points) {
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0, "an expression without storage: evaluate it first");
  static_assert(Derived::ColsAtCompileTime == 3 || Derived::ColsAtCompileTime == Eigen::Dynamic, "points are N x 3");
  const Derived& m = points.derived();
  if (m.cols() != 3) {
    throw std::invalid_argument("points have " + std::to_string(m.rows()) + " x " + std::to_string(m.cols()) +
                                " coordinates, expected N x 3");
  }
  return {m.data(), static_cast<std::size_t>(m.rows()), m.rowStride(), m.colStride()};
}

template <typename Derived>
void row_points(const Eigen::PlainObjectBase<Derived>&& points) = delete;

}  // namespace consimd
