// Registration by any solver.
#include <consimd/solvers/registration.hpp>

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/assumed_inliers.hpp>
#include <consimd/solvers/edge_information.hpp>
#include <consimd/solvers/noise_bound.hpp>
#include <consimd/solvers/significance.hpp>
#include <consimd/solvers/solver.hpp>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"
#include "interruptible_call.hpp"
#include "named_values.hpp"
#include "result_fields.hpp"
#include "solver_options.hpp"
#include "stop_arguments.hpp"
#include "threads.hpp"

namespace consimd::python {

template <>
struct NamedValues<PoseGraphLibrary> {
  static constexpr std::array kValues{Named{"gtsam", PoseGraphLibrary::gtsam}, Named{"g2o", PoseGraphLibrary::g2o},
                                      Named{"open3d", PoseGraphLibrary::open3d}};
};

namespace {

nb::list to_list(const std::vector<StageReport>& stages) {
  nb::list list;
  for (const StageReport& stage : stages) {
    list.append(nb::make_tuple(stage.name, stage.input, stage.output, stage.iterations, stage.seconds));
  }
  return list;
}

/// Numbers for numpy.frombuffer: several times quicker than an array made here, which counts where a call takes 0.2 ms.
template <typename Numbers>
nb::bytearray to_bytes(const Numbers& numbers) {
  return nb::bytearray(numbers.data(), static_cast<std::size_t>(numbers.size()) * sizeof(*numbers.data()));
}

/// Milliseconds at most, so that a signal can wait, and the thread that `call_interruptibly` starts would cost as much
/// again.
bool is_brief(std::string_view solver, std::size_t rows, const SolverOptions& options, const nb::dict& given) {
  constexpr std::size_t kMostRows = 20'000;
  return solver == "tcf" && options.noise_bound && rows <= kMostRows && given.empty();
}

nb::dict run_solver(const SharedCorrespondences& correspondences, std::string_view solver,
                    std::optional<double> noise_bound, std::uint64_t seed, std::string_view filter,
                    std::optional<int> threads, std::optional<double> time_limit, const nb::dict& given) {
  SolverOptions options;
  options.noise_bound = noise_bound;
  options.seed = seed;
  options.filter = filter_by_name(filter);
  const std::optional<int> limit = checked_threads(threads);
  const SolverChoice choice = solver_with_options(solver, given);
  require_time_limit(time_limit);
  const auto rows = correspondences.rows;
  const bool brief = is_brief(solver, rows->size(), options, given);
  const auto work = [rows, choice, options, limit, time_limit](const std::atomic<bool>& interrupted) {
    SolverOptions stopped = options;
    stopped.stop = stop_of(time_limit, interrupted);
    return with_threads(limit, [&] { return register_by_choice(choice, *rows, stopped); });
  };
  if (!brief) return registration_fields(stoppable_result<Registration>(work));
  Registration result;
  {
    const nb::gil_scoped_release unlocked;
    result = work(false);
  }
  return registration_fields(result);
}

nb::dict run_assumed_inliers(const SharedCorrespondences& correspondences) {
  AssumedInliers result;
  {
    const nb::gil_scoped_release unlocked;
    result = register_assumed_inliers(*correspondences.rows);
  }
  nb::dict fields = registration_fields(result.registration);
  fields["residuals"] = to_bytes(result.residuals);
  fields["sigma"] = result.sigma;
  fields["geometry"] = to_string(result.geometry);
  fields["other_scale"] = result.other_scale;
  fields["odd_row"] = result.odd_row;
  return fields;
}

nb::tuple estimate(const SharedCorrespondences& correspondences, std::uint64_t seed, std::optional<int> threads) {
  const auto rows = correspondences.rows;
  const std::optional<int> limit = checked_threads(threads);
  const auto result = interruptible_result<NoiseBoundEstimate>(
      [rows, seed, limit] { return with_threads(limit, [&] { return estimate_noise_bound(*rows, seed); }); });
  return nb::make_tuple(result.noise_bound, result.log10_false_poses, result.bounds_tried);
}

double log10_false_poses(const SharedCorrespondences& correspondences, ArrayLike pose, double noise_bound) {
  const auto rows = correspondences.rows;
  const RigidTransform T_target_source = transform_from(pose, "pose");
  const nb::gil_scoped_release unlocked;
  return significance(*rows, to_working_pose(to_working_frame(T_target_source, *rows)), noise_bound, Scrutiny::close)
      .log10_false_poses;
}

Array<double, 6, 6> information_of(
    ArrayLike pose, const nb::ndarray<const double, nb::shape<6, 6>, nb::c_contig, nb::device::cpu>& covariance,
    std::string_view library) {
  const PoseCovariance of_pose = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance.data());
  return to_array(
      edge_information(transform_from(pose, "pose"), of_pose, value_named<PoseGraphLibrary>(library, "library")));
}

}  // namespace

nb::dict registration_fields(const Registration& result) {
  nb::dict fields;
  fields["status"] = to_string(result.status);
  fields["pose"] = nb::none();
  if (result.has_pose()) {
    fields["pose"] = to_bytes(Eigen::Matrix<double, 4, 4, Eigen::RowMajor>(result.T_target_source.matrix()));
  }
  fields["scale"] = result.scale;
  fields["scale_deviation"] = result.scale_deviation;
  fields["covariance"] = to_bytes(Eigen::Matrix<double, 6, 6, Eigen::RowMajor>(result.covariance));
  fields["inliers"] = to_bytes(std::vector<std::int64_t>(result.inliers.begin(), result.inliers.end()));
  fields["log10_false_poses"] = result.log10_false_poses;
  for (const auto& [name, pose] : {std::pair("runner_up", &result.runner_up), std::pair("refused", &result.refused)}) {
    fields[name] = nb::none();
    if (*pose) {
      fields[name] = nb::make_tuple(to_array((*pose)->T_target_source), (*pose)->support, (*pose)->log10_false_poses,
                                    (*pose)->scale);
    }
  }
  fields["stages"] = to_list(result.stages);
  fields["seconds"] = result.seconds;
  fields["seed"] = result.seed;
  fields["isa"] = to_string(result.isa);
  fields["threads"] = result.threads;
  fields["noise_bound"] = result.noise_bound;
  fields["noise_bound_asked"] = result.noise_bound_asked;
  fields["mirrored"] = result.mirrored;
  fields["stopped"] = result.stopped;
  fields["consistency_bound"] = result.consistency_bound;
  return fields;
}

void bind_registration(nb::module_& module) {
  module.def("run_solver", &run_solver, nb::arg("correspondences"), nb::arg("solver"), nb::arg("noise_bound").none(),
             nb::arg("seed"), nb::arg("filter"), nb::arg("threads").none(), nb::arg("time_limit").none(),
             nb::arg("options"));
  module.def("run_assumed_inliers", &run_assumed_inliers, nb::arg("correspondences"));
  module.def("estimate_noise_bound", &estimate, nb::arg("correspondences"), nb::arg("seed"), nb::arg("threads").none());
  module.def("log10_false_poses", &log10_false_poses, nb::arg("correspondences"), nb::arg("pose"),
             nb::arg("noise_bound"));
  module.def("edge_information", &information_of, nb::arg("pose"), nb::arg("covariance"), nb::arg("library"));
  module.def("describe_options", &describe_options, nb::arg("solver"));
  module.def("solvers", [] {
    nb::dict all;
    for (const std::string& name : solver_names()) all[nb::cast(name)] = SolverChoice(name).description();
    return all;
  });
}

}  // namespace consimd::python
