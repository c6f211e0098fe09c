// NumPy arrays, and whatever else holds numbers, as the library takes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd::python {

namespace nb = nanobind;

/// An argument that may be an array, a nested sequence, or anything that numpy.asarray understands.
struct ArrayLike {
  nb::handle object;
};

using AnyArray = nb::ndarray<nb::ro, nb::device::cpu>;

/// N x 3 points of a Python object. Arrays of float32 and float64 are borrowed, whatever their strides; others are
/// copied once, as float64.
class Points {
 public:
  /// Throws nb::value_error that says what to pass where the shape is not (N, 3), nb::type_error where `points` does
  /// not hold real numbers. name: of the argument.
  Points(ArrayLike points, std::string_view name);

  [[nodiscard]] bool single_precision() const noexcept { return array_.dtype() == nb::dtype<float>(); }
  [[nodiscard]] std::size_t size() const noexcept { return array_.shape(0); }
  /// Makes them float64, with a copy if they are not.
  void widen();
  /// T: what they are.
  template <typename T>
  [[nodiscard]] PointSpan<T> span() const {
    return {static_cast<const T*>(array_.data()), size(), array_.stride(0), array_.stride(1)};
  }

 private:
  AnyArray array_;
};

/// N x 3 points as a cloud, see Cloud's constructor. Throws as Points.
[[nodiscard]] Cloud cloud_from(ArrayLike points, std::string_view name, std::optional<double> missing);

/// Whole numbers from 0 to 2^32 - 1 in an array of shape (M,), or (M, columns) where columns > 0, row by row. Throws
/// nb::value_error and nb::type_error that name the argument and the first bad entry.
[[nodiscard]] std::vector<std::uint32_t> indices_from(ArrayLike indices, std::string_view name,
                                                      std::size_t columns = 0);

/// Numbers in an array of shape (size,). Throws as above.
[[nodiscard]] std::vector<float> floats_from(ArrayLike values, std::string_view name, std::size_t size);

/// 64-bit words in a uint64 array of shape (words,), or of any length where words is 0. Throws as above.
[[nodiscard]] std::vector<std::uint64_t> words_from(ArrayLike words_array, std::string_view name,
                                                    std::size_t words = 0);

/// Truth values in an array of shape (size,). Throws as above.
[[nodiscard]] std::vector<std::uint8_t> mask_from(ArrayLike mask, std::string_view name, std::size_t size);

/// Poses [R | t] of an array of shape (H, 3, 4). Throws as above.
[[nodiscard]] std::vector<WorkingPose> working_poses_from(ArrayLike poses);
/// One of shape (3, 4).
[[nodiscard]] WorkingPose working_pose_from(ArrayLike pose);

/// A rigid motion of shape (4, 4) or (3, 4). Throws as above, also if the rotation is not one (to 1e-3; all NaN is let
/// through).
[[nodiscard]] RigidTransform transform_from(ArrayLike transform, std::string_view name);

}  // namespace consimd::python

/// Takes every object: the functions above say what is wrong with it.
template <>
struct nanobind::detail::type_caster<consimd::python::ArrayLike> {
  NB_TYPE_CASTER(consimd::python::ArrayLike, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    value.object = source;
    return true;
  }
};
