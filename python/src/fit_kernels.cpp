// Kernels that make poses: moments, fits, minimal fits, and the frames that poses are in.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include <consimd/kernels/rigid_moments.hpp>
#include <consimd/kernels/three_point_fit.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"
#include "named_values.hpp"

namespace consimd::python {

template <>
struct NamedValues<WeightFunction> {
  static constexpr std::array kValues{Named{"truncated", WeightFunction::truncated},
                                      Named{"cauchy", WeightFunction::cauchy},
                                      Named{"student_uniform", WeightFunction::student_uniform}};
};

namespace {

constexpr std::size_t kAlignedFloats = 16;  // 64 bytes

/// Weights at a 64-byte boundary, padded as the kernels want them.
class AlignedWeights {
 public:
  AlignedWeights(ArrayLike weights, const CorrespondenceView& view)
      : storage_(view.padded_size() + kAlignedFloats), padded_(view.padded_size()) {
    const std::vector<float> values = floats_from(weights, "weights", view.size());
    void* start = storage_.data();
    std::size_t space = storage_.size() * sizeof(float);
    first_ = static_cast<float*>(std::align(64, view.padded_size() * sizeof(float), start, space));
    std::copy(values.begin(), values.end(), first_);
  }
  [[nodiscard]] std::span<const float> span() const noexcept { return {first_, padded_}; }

 private:
  std::vector<float> storage_;
  std::size_t padded_;
  float* first_;
};

RigidMoments bound_weighted_moments(const SharedCorrespondences& c, ArrayLike weights_like) {
  const AlignedWeights weights(weights_like, *c.rows);
  const nb::gil_scoped_release unlocked;
  return weighted_moments(*c.rows, weights.span());
}

RigidMoments bound_subset_moments(const SharedCorrespondences& c, ArrayLike bits_like) {
  const std::vector<std::uint64_t> bits = words_from(bits_like, "bits", c.rows->view().words());
  const nb::gil_scoped_release unlocked;
  return subset_moments(*c.rows, bits);
}

RigidMoments bound_robust_moments(const SharedCorrespondences& c, ArrayLike pose_like, std::string_view function,
                                  double scale, double cutoff, double odds, std::uint32_t exponent) {
  const WorkingPose pose = working_pose_from(pose_like);
  const RobustWeight weight{value_named<WeightFunction>(function, "function"), scale, cutoff, odds, exponent};
  const nb::gil_scoped_release unlocked;
  return robust_moments(*c.rows, pose, weight);
}

PosesArray bound_three_point_fits(const SharedCorrespondences& c, ArrayLike triples_like) {
  const std::vector<std::uint32_t> indices = indices_from(triples_like, "triples", 3);
  std::vector<IndexTriple> triples;
  for (std::size_t k = 0; k < indices.size(); k += 3) triples.push_back({indices[k], indices[k + 1], indices[k + 2]});
  std::vector<WorkingPose> poses(triples.size());
  {
    const nb::gil_scoped_release unlocked;
    three_point_fits(*c.rows, triples, poses);
  }
  return to_array(poses);
}

/// One of the arrays of a RigidMoments, as a copy.
template <nb::ssize_t... Shape, std::size_t Size>
Array<double, Shape...> copy_of(const double (&values)[Size], std::initializer_list<std::size_t> shape) {
  return to_array<Array<double, Shape...>>(std::vector<double>(values, values + Size), shape);
}

void bind_moments(nb::module_& module) {
  nb::class_<RigidMoments>(module, "RigidMoments",
                           "Weighted sums over correspondences, working frame: all that a rigid fit needs.")
      .def_ro("weight", &RigidMoments::weight, "sum w")
      .def_prop_ro(
          "source", [](const RigidMoments& m) { return copy_of<3>(m.source, {3}); }, nb::rv_policy::automatic,
          "(3,) sum w p")
      .def_prop_ro(
          "target", [](const RigidMoments& m) { return copy_of<3>(m.target, {3}); }, nb::rv_policy::automatic,
          "(3,) sum w q")
      .def_prop_ro(
          "cross",
          [](const RigidMoments& m) {
            return copy_of<3, 3>(m.cross, {3, 3});
          },
          nb::rv_policy::automatic, "(3, 3) sum w q p^T")
      .def_prop_ro(
          "source_scatter", [](const RigidMoments& m) { return copy_of<6>(m.source_scatter, {6}); },
          nb::rv_policy::automatic, "(6,) sum w p p^T: xx, xy, xz, yy, yz, zz")
      .def_ro("residual", &RigidMoments::residual, "sum w r^2; robust_moments only, else 0");

  const nb::arg c("correspondences");
  const RobustWeight defaults;
  module.def("weighted_moments", &bound_weighted_moments, c, nb::arg("weights"),
             "Moments with given weights, (N,), used in single precision.");
  module.def("subset_moments", &bound_subset_moments, c, nb::arg("bits"),
             "Moments over the rows whose bit is set. bits: (words,) uint64, see kernels.pack_bits.");
  module.def(
      "robust_moments", &bound_robust_moments, c, nb::arg("pose"), nb::arg("function") = "truncated",
      nb::arg("scale") = defaults.scale, nb::arg("cutoff") = defaults.cutoff, nb::arg("odds") = defaults.odds,
      nb::arg("exponent") = defaults.exponent,
      "One pass of an iteratively reweighted fit: moments with weights from the residuals r under a pose,\n"
      "(3, 4), working frame. Weights are 0 from r = cutoff on (caller's unit, > 0), below it by `function`:\n"
      "'truncated' 1; 'cauchy' 1 / (1 + r^2 / scale^2), scale in the caller's unit, > 0;\n"
      "'student_uniform' 1 / (y (1 + odds y^exponent)), y = 1 + r^2 / (2 exponent scale^2), odds >= 0 the density\n"
      "of outliers over that of inliers at r = 0, exponent a power of two from 2 to 64.");
}

}  // namespace

void bind_fit_kernels(nb::module_& module) {
  bind_moments(module);
  nb::class_<RigidFit>(module, "RigidFit", "A least-squares rigid motion, and how well the data determine it.")
      .def_prop_ro(
          "pose", [](const RigidFit& fit) { return to_array(fit.pose); }, nb::rv_policy::automatic,
          "(4, 4), frame of the moments")
      .def_prop_ro(
          "singular_values",
          [](const RigidFit& fit) {
            return to_array(std::vector<double>(fit.singular_values.data(), fit.singular_values.data() + 3));
          },
          nb::rv_policy::automatic,
          "(3,) of the cross-covariance, descending; the last negative if the best orthogonal matrix is a reflection")
      .def_prop_ro("determined", &RigidFit::determined,
                   "False for too few, coincident or collinear points: the rotation is then any of many.");
  module.def("rigid_fit", &rigid_fit, nb::arg("moments"),
             "Kabsch's fit: the minimiser of sum w |R p + t - q|^2 over proper rotations.");
  module.def(
      "three_point_fits", &bound_three_point_fits, nb::arg("correspondences"), nb::arg("triples"),
      "The least-squares rigid pose of each triple of rows, never a reflection; NaN where a triangle is degenerate.\n"
      "triples: (H, 3) rows. Returns (H, 3, 4) float32 [R | t], working frame.");
  module.def(
      "to_working_pose", [](ArrayLike pose) { return to_array(to_working_pose(transform_from(pose, "pose"))); },
      nb::arg("pose"), "A working-frame pose, (4, 4), as the kernels take it: (3, 4) float32.");
  module.def(
      "from_working_pose", [](ArrayLike pose) { return to_array(from_working_pose(working_pose_from(pose))); },
      nb::arg("pose"), "A kernel's pose, (3, 4), as (4, 4) float64 with its rotation made orthonormal; working frame.");
  module.def(
      "to_caller_frame",
      [](ArrayLike working, const SharedCorrespondences& frame) {
        return to_array(to_caller_frame(transform_from(working, "working"), *frame.rows));
      },
      nb::arg("working"), nb::arg("correspondences"),
      "A working-frame pose, (4, 4), as the pose that takes source points to the target frame, caller's unit.");
  module.def(
      "to_working_frame",
      [](ArrayLike pose, const SharedCorrespondences& frame) {
        return to_array(to_working_frame(transform_from(pose, "pose"), *frame.rows));
      },
      nb::arg("pose"), nb::arg("correspondences"), "Inverse of to_caller_frame.");
}

}  // namespace consimd::python
