// What the library returns, as NumPy arrays.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <Eigen/Core>

#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::python {

namespace nb = nanobind;

template <typename T, nb::ssize_t... Shape>
using Array = nb::ndarray<nb::numpy, T, nb::shape<Shape...>>;
/// Its memory belongs to another object.
template <typename T, nb::ssize_t... Shape>
using View = nb::ndarray<nb::numpy, const T, nb::shape<Shape...>>;

using PoseArray = Array<double, 4, 4>;
using PosesArray = Array<float, -1, 3, 4>;

/// Without a copy: the array keeps the vector.
template <typename ArrayType, typename T>
[[nodiscard]] ArrayType to_array(std::vector<T> values, std::initializer_list<std::size_t> shape) {
  auto* kept = new std::vector<T>(std::move(values));
  const nb::capsule owner(kept, [](void* pointer) noexcept { delete static_cast<std::vector<T>*>(pointer); });
  return ArrayType(kept->data(), shape, owner);
}

template <typename T>
[[nodiscard]] Array<T, -1> to_array(std::vector<T> values) {
  const std::size_t size = values.size();
  return to_array<Array<T, -1>>(std::move(values), {size});
}

/// Row-major.
template <int Rows, int Columns, int Options>
[[nodiscard]] Array<double, Rows, Columns> to_array(const Eigen::Matrix<double, Rows, Columns, Options>& matrix) {
  std::vector<double> values(Rows * Columns);
  Eigen::Map<Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(values.data()) = matrix;
  return to_array<Array<double, Rows, Columns>>(std::move(values), {Rows, Columns});
}

[[nodiscard]] inline Array<double, -1, 3> points_array(const std::vector<std::array<double, 3>>& points) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const auto& p : points) values.insert(values.end(), p.begin(), p.end());
  return to_array<Array<double, -1, 3>>(std::move(values), {points.size(), 3});
}

[[nodiscard]] inline PoseArray to_array(const RigidTransform& transform) {
  return to_array(Eigen::Matrix<double, 4, 4, Eigen::DontAlign>(transform.matrix()));
}

/// 12 numbers [R | t] a pose.
inline void put_rows(const WorkingPose& pose, float* rows) {
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) rows[4 * row + column] = pose.rotation[3 * row + column];
    rows[4 * row + 3] = pose.translation[row];
  }
}

[[nodiscard]] inline PosesArray to_array(const std::vector<WorkingPose>& poses) {
  std::vector<float> values(12 * poses.size());
  for (std::size_t h = 0; h < poses.size(); ++h) put_rows(poses[h], values.data() + 12 * h);
  return to_array<PosesArray>(std::move(values), {poses.size(), 3, 4});
}

[[nodiscard]] inline Array<float, 3, 4> to_array(const WorkingPose& pose) {
  std::vector<float> values(12);
  put_rows(pose, values.data());
  return to_array<Array<float, 3, 4>>(std::move(values), {3, 4});
}

}  // namespace consimd::python
