#include "array_arguments.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/string.h>
#include <Eigen/Dense>

namespace consimd::python {
namespace {

std::string shape_of(const AnyArray& array) {
  const std::vector<std::int64_t> shape(array.shape_ptr(), array.shape_ptr() + array.ndim());
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

[[noreturn]] void reject_shape(std::string_view name, const AnyArray& array, std::string_view expected) {
  throw nb::value_error(fmt::format("{} has shape {}, expected {}", name, shape_of(array), expected).c_str());
}

[[noreturn]] void reject_type(std::string_view name, nb::handle type, std::string_view expected) {
  throw nb::type_error(fmt::format("{} has dtype {}, expected {}", name, nb::str(type).c_str(), expected).c_str());
}

/// The object as it is, if its memory can be read in place.
std::optional<AnyArray> borrowed(nb::handle object) {
  AnyArray array;
  if (!nb::ndarray_check(object) || !nb::try_cast(object, array, false)) return std::nullopt;
  return array;
}

/// What holds numbers in a way of its own, and how to get at them.
void reject_containers(nb::handle object, std::string_view name) {
  const auto type = nb::cast<std::string>(nb::borrow(object.type()).attr("__module__"));
  if (type.starts_with("numpy.ma")) {
    throw nb::type_error(
        fmt::format("{} is a masked array, whose mask would be ignored: pass the rows without a masked value, for "
                    "both clouds: keep = ~(numpy.ma.getmaskarray(source) | numpy.ma.getmaskarray(target)).any(axis=1)",
                    name)
            .c_str());
  }
  if (type.starts_with("open3d") && nb::hasattr(object, "points")) {
    throw nb::type_error(fmt::format("{} is an Open3D cloud: pass numpy.asarray({}.points)", name, name).c_str());
  }
}

/// The way out for arrays that NumPy holds as Python objects.
std::string remedy_of(nb::handle object, std::string_view name) {
  if (nb::hasattr(object, "to_numpy")) return fmt::format(": pass {}.to_numpy(float)", name);
  if (nb::hasattr(object, "numpy")) return fmt::format(": pass {}.numpy()", name);
  return "";
}

nb::object numpy_array(nb::handle object) { return nb::module_::import_("numpy").attr("asarray")(object); }

/// Real numbers as a fresh C-ordered array of `type`. kinds: those of NumPy's type codes to take.
AnyArray converted(nb::handle object, std::string_view name, const char* type, std::string_view kinds,
                   std::string_view expected) {
  const nb::object array = numpy_array(object);
  const nb::object dtype = array.attr("dtype");
  const bool empty = nb::cast<std::size_t>(array.attr("size")) == 0;
  if (!empty && kinds.find(nb::cast<std::string>(dtype.attr("kind"))) == std::string_view::npos) {
    reject_type(name, dtype, fmt::format("{}{}", expected, remedy_of(object, name)));
  }
  const nb::object fresh =
      nb::module_::import_("numpy").attr("array")(array, nb::arg("dtype") = type, nb::arg("order") = "C");
  return *borrowed(fresh);
}

bool is(const AnyArray& array, nb::dlpack::dtype_code code) {
  return array.dtype().code == static_cast<std::uint8_t>(code) && array.dtype().lanes == 1;
}

AnyArray real_array(nb::handle object, std::string_view name) {
  reject_containers(object, name);
  std::optional<AnyArray> array = borrowed(object);
  if (array && (array->dtype() == nb::dtype<float>() || array->dtype() == nb::dtype<double>())) return *array;
  return converted(object, name, "float64", "fiub", "real numbers");
}

/// Element (i, j, ...) in the row-major order of the shape, read by the array's strides.
template <typename T, typename Take>
void for_each_element(const AnyArray& array, const Take& take) {
  const auto* data = static_cast<const T*>(array.data());
  const std::size_t count = array.size();
  for (std::size_t k = 0; k < count; ++k) {
    std::size_t rest = k;
    std::int64_t offset = 0;
    for (std::size_t axis = array.ndim(); axis-- > 0;) {
      offset += static_cast<std::int64_t>(rest % array.shape(axis)) * array.stride(axis);
      rest /= array.shape(axis);
    }
    take(k, data[offset]);
  }
}

template <typename T>
std::vector<T> numbers_of(const AnyArray& array) {
  std::vector<T> numbers(array.size());
  const auto take = [&](std::size_t k, auto value) { numbers[k] = static_cast<T>(value); };
  if (array.dtype() == nb::dtype<float>()) {
    for_each_element<float>(array, take);
  } else {
    for_each_element<double>(array, take);
  }
  return numbers;
}

template <typename T>
void take_indices(const AnyArray& array, std::string_view name, std::vector<std::uint32_t>& indices) {
  for_each_element<T>(array, [&](std::size_t k, T value) {
    if (!std::in_range<std::uint32_t>(value)) {
      throw nb::value_error(
          fmt::format("{} holds {} (element {}), expected whole numbers from 0 to 4294967295", name, value, k).c_str());
    }
    indices[k] = static_cast<std::uint32_t>(static_cast<std::make_unsigned_t<T>>(value));
  });
}

WorkingPose to_pose(const float* rows) {
  WorkingPose pose{};
  for (std::size_t row = 0; row < 3; ++row) {
    std::copy_n(rows + 4 * row, 3, pose.rotation + 3 * row);
    pose.translation[row] = rows[4 * row + 3];
  }
  return pose;
}

}  // namespace

Points::Points(ArrayLike points, std::string_view name) : array_(real_array(points.object, name)) {
  if (array_.ndim() == 2 && array_.shape(1) == 3) return;
  std::string remedy;
  if (array_.ndim() == 2 && array_.shape(0) == 3) {
    remedy = fmt::format(": pass {}.T", name);
  } else if (array_.ndim() == 2 && array_.shape(1) > 3) {
    remedy = fmt::format(": pass {}[:, :3] if x, y and z come first", name);
  } else if (array_.ndim() == 1 && array_.shape(0) % 3 == 0) {
    remedy = fmt::format(": pass {}.reshape(-1, 3)", name);
  }
  reject_shape(name, array_, fmt::format("(N, 3), a point a row{}", remedy));
}

void Points::widen() {
  if (!single_precision()) return;
  array_ = converted(nb::cast(array_), "points", "float64", "f", "real numbers");
}

Cloud cloud_from(ArrayLike points, std::string_view name, std::optional<double> missing) {
  const Points array(points, name);
  if (array.single_precision()) return Cloud(array.span<float>(), missing);
  return Cloud(array.span<double>(), missing);
}

std::vector<std::uint32_t> indices_from(ArrayLike indices, std::string_view name, std::size_t columns) {
  constexpr std::string_view kExpected = "whole numbers (of a mask: numpy.flatnonzero(mask))";
  std::optional<AnyArray> found = borrowed(indices.object);
  if (!found || (!is(*found, nb::dlpack::dtype_code::Int) && !is(*found, nb::dlpack::dtype_code::UInt))) {
    found = converted(indices.object, name, "int64", "iu", kExpected);
  }
  const AnyArray& array = *found;
  if (columns == 0 ? array.ndim() != 1 : array.ndim() != 2 || array.shape(1) != columns) {
    reject_shape(name, array, columns == 0 ? "(M,)" : fmt::format("(M, {})", columns));
  }
  std::vector<std::uint32_t> result(array.size());
  const bool is_signed = is(array, nb::dlpack::dtype_code::Int);
  switch (array.dtype().bits) {
    case 8:
      is_signed ? take_indices<std::int8_t>(array, name, result) : take_indices<std::uint8_t>(array, name, result);
      break;
    case 16:
      is_signed ? take_indices<std::int16_t>(array, name, result) : take_indices<std::uint16_t>(array, name, result);
      break;
    case 32:
      is_signed ? take_indices<std::int32_t>(array, name, result) : take_indices<std::uint32_t>(array, name, result);
      break;
    default:
      is_signed ? take_indices<std::int64_t>(array, name, result) : take_indices<std::uint64_t>(array, name, result);
  }
  return result;
}

std::vector<float> floats_from(ArrayLike values, std::string_view name, std::size_t size) {
  const AnyArray array = real_array(values.object, name);
  if (array.ndim() != 1 || array.shape(0) != size) reject_shape(name, array, fmt::format("({},)", size));
  return numbers_of<float>(array);
}

std::vector<std::uint64_t> words_from(ArrayLike words_array, std::string_view name, std::size_t words) {
  const std::optional<AnyArray> found = borrowed(words_array.object);
  if (!found || found->dtype() != nb::dtype<std::uint64_t>()) {
    reject_type(name, numpy_array(words_array.object).attr("dtype"), "uint64 words, as kernels.pack_bits makes them");
  }
  if (found->ndim() != 1 || (words != 0 && found->shape(0) != words)) {
    reject_shape(name, *found, words == 0 ? "(words,)" : fmt::format("({},)", words));
  }
  std::vector<std::uint64_t> result(found->size());
  for_each_element<std::uint64_t>(*found, [&](std::size_t k, std::uint64_t value) { result[k] = value; });
  return result;
}

std::vector<std::uint8_t> mask_from(ArrayLike mask, std::string_view name, std::size_t size) {
  const AnyArray array = converted(mask.object, name, "bool", "biu", "truth values");
  if (array.ndim() != 1 || array.shape(0) != size) reject_shape(name, array, fmt::format("({},)", size));
  const auto* data = static_cast<const std::uint8_t*>(array.data());
  return {data, data + array.size()};
}

std::vector<WorkingPose> working_poses_from(ArrayLike poses) {
  const AnyArray array = real_array(poses.object, "poses");
  if (array.ndim() != 3 || array.shape(1) != 3 || array.shape(2) != 4) {
    reject_shape("poses", array, "(H, 3, 4), [R | t] in the working frame");
  }
  const std::vector<float> numbers = numbers_of<float>(array);
  std::vector<WorkingPose> result;
  result.reserve(array.shape(0));
  for (std::size_t h = 0; h < array.shape(0); ++h) result.push_back(to_pose(numbers.data() + 12 * h));
  return result;
}

WorkingPose working_pose_from(ArrayLike pose) {
  const AnyArray array = real_array(pose.object, "pose");
  if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 4) {
    reject_shape("pose", array, "(3, 4), [R | t] in the working frame");
  }
  return to_pose(numbers_of<float>(array).data());
}

RigidTransform transform_from(ArrayLike transform, std::string_view name) {
  const AnyArray array = real_array(transform.object, name);
  const bool homogeneous = array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4;
  if (!homogeneous && (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 4)) {
    reject_shape(name, array, "(4, 4) or (3, 4), [R | t]");
  }
  const std::vector<double> numbers = numbers_of<double>(array);
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> rows(numbers.data());
  const Eigen::Matrix3d rotation = rows.leftCols<3>();
  const Eigen::Matrix3d deviation = rotation * rotation.transpose() - Eigen::Matrix3d::Identity();
  const bool proper = deviation.cwiseAbs().maxCoeff() <= 1e-3 && rotation.determinant() > 0.0;
  if (!proper && !rotation.array().isNaN().all()) {
    throw nb::value_error(fmt::format("{} is not a rigid motion: its rotation is not one", name).c_str());
  }
  RigidTransform result = RigidTransform::Identity();
  result.matrix().topRows<3>() = rows;
  return result;
}

}  // namespace consimd::python
