// Errors against the ground truth.
#include <consimd/synth/metrics.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"

namespace consimd::python {

void bind_metrics(nb::module_& module) {
  module.def(
      "rotation_error_deg",
      [](ArrayLike estimate, ArrayLike truth) {
        return synth::rotation_error_deg(transform_from(estimate, "estimate"), transform_from(truth, "truth"));
      },
      nb::arg("estimate"), nb::arg("truth"), "Angle between the rotations of two poses, (4, 4), in degrees, [0, 180].");
  module.def(
      "translation_error",
      [](ArrayLike estimate, ArrayLike truth) {
        return synth::translation_error(transform_from(estimate, "estimate"), transform_from(truth, "truth"));
      },
      nb::arg("estimate"), nb::arg("truth"), "Distance between the translations of two poses, (4, 4), in their unit.");
  module.def("scale_error", &synth::scale_error, nb::arg("estimate"), nb::arg("truth"),
             "Relative difference of two scales, |estimate / truth - 1|.");
  module.def(
      "rmse_true_inliers",
      [](const synth::Problem& problem, ArrayLike estimate, double scale) {
        return synth::rmse_true_inliers(problem, transform_from(estimate, "estimate"), scale);
      },
      nb::arg("problem"), nb::arg("estimate"), nb::arg("scale") = 1.0,
      "Root mean square of |R (scale p) + t - q| over the true inliers, the problem's unit; NaN without any. The\n"
      "scale belongs to the estimate. The noise study counts a pose as a success below 3 sigma.");
  module.def(
      "inlier_quality",
      [](const synth::Problem& problem, ArrayLike reported) {
        const synth::InlierQuality quality = synth::inlier_quality(problem, indices_from(reported, "reported"));
        return nb::make_tuple(quality.precision, quality.recall);
      },
      nb::arg("problem"), nb::arg("reported"),
      nb::sig("def inlier_quality(problem: Problem, reported: numpy.typing.ArrayLike) -> tuple[float, float]"),
      "Precision and recall of reported inliers, (M,) rows. NaN where there is nothing to divide by.");
  module.def(
      "oracle", [](const synth::Problem& problem) { return to_array(synth::oracle(problem)); }, nb::arg("problem"),
      "The least-squares rigid motion of the true inliers, (4, 4): the best that a solver, which has to find them, "
      "can\n"
      "be expected to do. NaN without inliers.");
}

}  // namespace consimd::python
