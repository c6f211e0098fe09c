// From two clouds to correspondences and a pose, and the refinement of one.
#include <consimd/features/cell_grid.hpp>
#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/matching.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include "array_results.hpp"
#include "bindings.hpp"
#include "cloud_calls.hpp"
#include "result_fields.hpp"
#include "stop_arguments.hpp"

namespace consimd::python {
namespace {

nb::dict refinement_fields(const features::Refinement& result) {
  nb::dict fields;
  fields["status"] = std::string(to_string(result.status));
  fields["pose"] = to_array(result.T_target_source);
  fields["covariance"] = to_array(result.covariance);
  fields["iterations"] = result.iterations;
  fields["pairs"] = result.pairs;
  fields["inlier_share"] = result.inlier_share;
  fields["rmse"] = result.rmse;
  fields["residual_scale"] = result.residual_scale;
  fields["shared_errors"] = result.shared_errors;
  fields["max_distance"] = result.max_distance;
  fields["seconds"] = result.seconds;
  return fields;
}

nb::dict refine(ArrayLike source, ArrayLike target, ArrayLike pose, const std::string& method,
                std::optional<double> voxel, double normal_radius, double cell_radius,
                std::optional<double> max_distance, std::uint32_t max_iterations, std::optional<double> missing,
                std::optional<int> threads) {
  const auto source_cloud = shared_cloud(source, "source", missing);
  const auto target_cloud = shared_cloud(target, "target", missing);
  const RigidTransform start = transform_from(pose, "pose");
  const features::RefinementOptions options{features::parse_refinement_method(method), max_distance, max_iterations};
  const auto result = result_of(threads, [=] {
    if (source_cloud->empty() || target_cloud->empty()) {
      return features::refine(*source_cloud, *target_cloud, start, options);
    }
    const double side =
        voxel ? *voxel : std::max(features::choose_voxel(*source_cloud), features::choose_voxel(*target_cloud));
    const auto prepared = [&](const Cloud& cloud) {
      features::CellGrid grid(features::voxel_grid(cloud, side), std::max(normal_radius, cell_radius) * side);
      features::estimate_normals(grid, {normal_radius * side, std::nullopt});
      return grid;
    };
    return features::refine(prepared(*source_cloud).cloud(), prepared(*target_cloud).cloud(), start, options);
  });
  return refinement_fields(*result);
}

nb::tuple summary(const features::CloudSummary& cloud) {
  return nb::make_tuple(cloud.points, cloud.left_out, cloud.voxels, cloud.descriptors, cloud.resolution);
}

/// What `match_clouds` and `register_clouds` take.
struct MatchingArguments {
  std::shared_ptr<const Cloud> source;
  std::shared_ptr<const Cloud> target;
  features::CloudMatchingOptions options;
};

nb::dict match_fields(const features::CloudMatches& result) {
  nb::dict fields;
  fields["source_points"] = points_array(result.source_points);
  fields["target_points"] = points_array(result.target_points);
  std::vector<float> distances;
  distances.reserve(result.matches.size());
  for (const features::Match& m : result.matches) distances.push_back(m.distance);
  fields["distances"] = to_array(std::move(distances));
  fields["source"] = summary(result.source);
  fields["target"] = summary(result.target);
  fields["voxel"] = result.voxel;
  fields["noise_bound"] = result.noise_bound;
  fields["hint"] = result.hint;
  nb::list stages;
  for (const StageReport& stage : result.stages) {
    stages.append(nb::make_tuple(stage.name, stage.input, stage.output, stage.iterations, stage.seconds));
  }
  fields["stages"] = stages;
  return fields;
}

nb::dict match_clouds(const MatchingArguments& arguments, std::optional<int> threads) {
  const auto result = result_of(
      threads, [=] { return features::match_clouds(*arguments.source, *arguments.target, arguments.options); });
  return match_fields(*result);
}

nb::object evidence_fields(const std::optional<features::PoseEvidence>& evidence) {
  if (!evidence) return nb::none();
  nb::dict fields;
  fields["log10_chance"] = evidence->log10_chance;
  fields["agreement"] = evidence->agreement;
  fields["seen_through"] = evidence->seen_through;
  fields["samples"] = evidence->samples;
  fields["displacements"] = evidence->displacements;
  fields["displaced_agreement"] = evidence->displaced_agreement;
  fields["displaced_seen_through"] = evidence->displaced_seen_through;
  fields["fitted_agreement"] = evidence->fitted_agreement;
  fields["fitted_seen_through"] = evidence->fitted_seen_through;
  fields["scale"] = evidence->scaled.scale;
  fields["gain_by_scale"] = evidence->scaled.gain;
  fields["rival"] = nb::none();
  if (const auto& rival = evidence->rival) {
    fields["rival"] = nb::make_tuple(to_array(rival->T_target_source), rival->share_of_score, rival->share_of_agreement,
                                     rival->agreement, rival->seen_through);
  }
  return fields;
}

nb::dict register_clouds(const MatchingArguments& arguments, std::optional<double> noise_bound,
                         const std::string& solver, bool verify, const std::optional<std::string>& refine,
                         std::optional<int> threads, std::optional<double> time_limit) {
  require_time_limit(time_limit);
  features::CloudRegistrationOptions options{.matching = arguments.options,
                                             .noise_bound = noise_bound,
                                             .solver = solver,
                                             .seed = arguments.options.seed,
                                             .verify = verify};
  if (refine) options.refine = features::parse_refinement_method(*refine);
  const std::optional<int> limit = checked_threads(threads);
  using Result = std::shared_ptr<features::CloudRegistration>;
  const auto result = stoppable_result<Result>([=](const std::atomic<bool>& interrupted) {
    features::CloudRegistrationOptions stopped = options;
    stopped.stop = stop_of(time_limit, interrupted);
    return with_threads(limit, [&] {
      return std::make_shared<features::CloudRegistration>(
          features::register_clouds(*arguments.source, *arguments.target, stopped));
    });
  });
  nb::dict fields;
  fields["registration"] = registration_fields(result->registration);
  fields["matches"] = match_fields(result->matches);
  fields["refinement"] = nb::none();
  if (result->refinement) fields["refinement"] = refinement_fields(*result->refinement);
  fields["verdict"] = nb::none();
  if (const auto& verdict = result->verdict) {
    fields["verdict"] =
        nb::make_tuple(evidence_fields(verdict->pose), evidence_fields(verdict->runner_up), verdict->log10_of_both,
                       verdict->found_by_clouds, to_string(verdict->of_correspondences));
  }
  fields["attempts"] = result->attempts;
  return fields;
}

/// Binds a function of MatchingArguments and what `more` names. The names are those of consimd.features.match_clouds.
template <typename... More, typename... Names>
void bind_on_clouds(nb::module_& module, const char* name, nb::dict (*call)(const MatchingArguments&, More...),
                    const Names&... more) {
  module.def(
      name,
      [call](ArrayLike source, ArrayLike target, std::optional<double> voxel, double normal_radius,
             double descriptor_radius, std::optional<std::size_t> keypoints, bool farthest, bool iss, double iss_radius,
             double iss_suppression_radius, std::size_t best, bool mutual, double ratio, std::uint64_t seed,
             const Viewpoint& source_viewpoint, const Viewpoint& target_viewpoint, std::optional<double> missing,
             More... rest) {
        return call({.source = shared_cloud(source, "source", missing),
                     .target = shared_cloud(target, "target", missing),
                     .options = {.voxel = voxel,
                                 .normal_radius = normal_radius,
                                 .descriptor_radius = descriptor_radius,
                                 .keypoints = keypoints,
                                 .farthest = farthest,
                                 .iss = iss,
                                 .iss_radius = iss_radius,
                                 .iss_suppression_radius = iss_suppression_radius,
                                 .matches = {best, mutual, ratio},
                                 .seed = seed,
                                 .source_viewpoint = source_viewpoint,
                                 .target_viewpoint = target_viewpoint}},
                    rest...);
      },
      nb::arg("source"), nb::arg("target"), nb::arg("voxel").none(), nb::arg("normal_radius"),
      nb::arg("descriptor_radius"), nb::arg("keypoints").none(), nb::arg("farthest"), nb::arg("iss"),
      nb::arg("iss_radius"), nb::arg("iss_suppression_radius"), nb::arg("best"), nb::arg("mutual"), nb::arg("ratio"),
      nb::arg("seed"), nb::arg("source_viewpoint").none(), nb::arg("target_viewpoint").none(),
      nb::arg("missing").none(), more...);
}

}  // namespace

void bind_cloud_registration(nb::module_& module) {
  module.def("refine", &refine, nb::arg("source"), nb::arg("target"), nb::arg("pose"), nb::arg("method"),
             nb::arg("voxel").none(), nb::arg("normal_radius"), nb::arg("cell_radius"), nb::arg("max_distance").none(),
             nb::arg("max_iterations"), nb::arg("missing").none(), nb::arg("threads").none());
  bind_on_clouds(module, "match_clouds", &match_clouds, nb::arg("threads").none());
  bind_on_clouds(module, "register_clouds", &register_clouds, nb::arg("noise_bound").none(), nb::arg("solver"),
                 nb::arg("verify"), nb::arg("refine").none(), nb::arg("threads").none(), nb::arg("time_limit").none());
}

}  // namespace consimd::python
