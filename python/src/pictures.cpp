// Registrations to look at.
#include <consimd/studies/registration_picture.hpp>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>

#include <consimd/studies/replace_file.hpp>

#include "array_arguments.hpp"
#include "bindings.hpp"
#include "named_values.hpp"

namespace consimd::python {

template <>
struct NamedValues<Status> {
  static constexpr std::array kValues{
      Named{"success", Status::success},           Named{"too_few_correspondences", Status::too_few_correspondences},
      Named{"no_consensus", Status::no_consensus}, Named{"degenerate_geometry", Status::degenerate_geometry},
      Named{"ambiguous", Status::ambiguous},       Named{"budget_exhausted", Status::budget_exhausted}};
};

namespace {

struct CloudPair {
  Cloud source;
  Cloud target;
};

/// What a picture shows of consimd.Registration.
Registration registration_from(nb::handle result) {
  Registration run;
  run.status = value_named<Status>(nb::cast<std::string>(nb::str(result.attr("status"))), "status");
  if (run.has_pose()) run.T_target_source = transform_from({result.attr("pose")}, "pose");
  run.scale = nb::cast<double>(result.attr("scale"));
  run.inliers = indices_from({result.attr("inliers")}, "inliers");
  run.log10_false_poses = nb::cast<double>(result.attr("log10_false_poses"));
  run.noise_bound = nb::cast<double>(result.attr("noise_bound"));
  if (const nb::object other = result.attr("runner_up"); !other.is_none()) {
    run.runner_up = RunnerUp{.T_target_source = transform_from({other.attr("pose")}, "runner_up.pose"),
                             .support = nb::cast<std::size_t>(other.attr("support")),
                             .scale = nb::cast<double>(other.attr("scale"))};
  }
  return run;
}

void write_picture(const std::string& file, bool drawing, nb::handle registration,
                   const SharedCorrespondences& correspondences, std::optional<std::tuple<ArrayLike, ArrayLike>> clouds,
                   std::optional<double> missing, const std::string& source_name, const std::string& target_name) {
  const Registration run = registration_from(registration);
  std::optional<CloudPair> pair;
  if (clouds) {
    pair = CloudPair{cloud_from(std::get<0>(*clouds), "source", missing),
                     cloud_from(std::get<1>(*clouds), "target", missing)};
  }
  const studies::RegistrationPicture picture{.correspondences = correspondences.rows.get(),
                                             .registration = &run,
                                             .source = pair ? &pair->source : nullptr,
                                             .target = pair ? &pair->target : nullptr,
                                             .source_name = source_name,
                                             .target_name = target_name,
                                             .solver = nb::cast<std::string>(registration.attr("solver"))};
  const nb::gil_scoped_release unlocked;
  studies::replace_file(file, drawing ? studies::registration_svg(picture) : studies::registration_page(picture));
}

}  // namespace

void bind_pictures(nb::module_& module) {
  module.def("write_picture", &write_picture, nb::arg("file"), nb::arg("drawing"), nb::arg("registration"),
             nb::arg("correspondences"), nb::arg("clouds").none(), nb::arg("missing").none(), nb::arg("source_name"),
             nb::arg("target_name"));
}

}  // namespace consimd::python
