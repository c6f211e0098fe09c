// From clouds to correspondences.
#include <consimd/features/cell_grid.hpp>
#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/fpfh.hpp>
#include <consimd/features/iss.hpp>
#include <consimd/features/matching.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/point_subset.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include "array_arguments.hpp"
#include "array_results.hpp"
#include "bindings.hpp"
#include "interruptible_call.hpp"
#include "result_fields.hpp"
#include "stop_arguments.hpp"
#include "threads.hpp"

namespace consimd::python {
namespace {

using Viewpoint = std::optional<std::array<double, 3>>;

Array<double, -1, 3> points_array(const std::vector<std::array<double, 3>>& points) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const auto& p : points) values.insert(values.end(), p.begin(), p.end());
  return to_array<Array<double, -1, 3>>(std::move(values), {points.size(), 3});
}

/// Runs `work` on all threads or fewer, until Ctrl-C; it must own what it uses. What it returns, shared.
template <typename Work>
auto result_of(std::optional<int> threads, const Work& work) {
  using Result = std::invoke_result_t<const Work&>;
  const std::optional<int> limit = checked_threads(threads);
  return interruptible_result<std::shared_ptr<Result>>(
      [limit, work] { return with_threads(limit, [&] { return std::make_shared<Result>(work()); }); });
}

std::shared_ptr<const Cloud> shared_cloud(ArrayLike points, const char* name, std::optional<double> missing) {
  return std::make_shared<const Cloud>(cloud_from(points, name, missing));
}

Array<double, -1, 3> voxel_grid(ArrayLike points, double voxel, std::optional<double> missing,
                                std::optional<int> threads) {
  return points_array(*result_of(threads, [cloud = shared_cloud(points, "points", missing), voxel] {
    const Cloud voxels = features::voxel_grid(*cloud, voxel);
    std::vector<std::array<double, 3>> means;
    means.reserve(voxels.size());
    for (std::size_t i = 0; i < voxels.size(); ++i) means.push_back(voxels.point(i));
    return means;
  }));
}

Array<std::int64_t, -1> farthest_subset(ArrayLike points, std::size_t count, std::uint64_t seed,
                                        std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  auto rows = result_of(threads, [cloud, count, seed] {
    std::vector<std::int64_t> chosen;
    for (const std::uint32_t row : features::farthest_subset(*cloud, count, seed)) {
      chosen.push_back(cloud->input_row(row));
    }
    return chosen;
  });
  return to_array(std::move(*rows));
}

double checked_radius(double radius) {
  if (std::isfinite(radius) && radius > 0.0) return radius;
  throw std::invalid_argument("radius is " + std::to_string(radius) + ", expected a finite length above 0");
}

/// A grid with normals, and the row of the caller's array that each of its points is.
struct DescribedCloud {
  features::CellGrid grid;
  std::vector<std::uint32_t> input_rows;

  DescribedCloud(const Cloud& cloud, double radius, double normal_radius, const Viewpoint& viewpoint)
      : grid(cloud, checked_radius(radius)), input_rows(cloud.size()) {
    features::estimate_normals(grid, {normal_radius, viewpoint});
    for (std::size_t row = 0; row < grid.size(); ++row) input_rows[row] = cloud.input_row(grid.original(row));
  }
};

Array<float, -1, 3> normals(ArrayLike points, double radius, const Viewpoint& viewpoint, std::optional<double> missing,
                            std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  const std::size_t size = cloud->size() + cloud->left_out();
  auto values = result_of(threads, [cloud, size, radius, viewpoint] {
    std::vector<float> found(3 * size, std::numeric_limits<float>::quiet_NaN());
    const DescribedCloud described(*cloud, radius, radius, viewpoint);
    const CloudView view = described.grid.cloud().view();
    for (std::size_t row = 0; row < view.size(); ++row) {
      for (std::size_t c = 0; c < 3; ++c) found[3 * described.input_rows[row] + c] = view.normals(c)[row];
    }
    return found;
  });
  return to_array<Array<float, -1, 3>>(std::move(*values), {size, 3});
}

Array<std::int64_t, -1> iss_keypoints(ArrayLike points, double radius, double suppression_radius,
                                      double second_to_first, double third_to_second, std::size_t fewest_neighbours,
                                      std::optional<double> missing, std::optional<int> threads) {
  const features::IssOptions options{checked_radius(radius), suppression_radius, second_to_first, third_to_second,
                                     fewest_neighbours};
  auto rows = result_of(threads, [cloud = shared_cloud(points, "points", missing), options] {
    std::vector<std::int64_t> keypoints;
    const features::CellGrid grid(*cloud, std::max(options.radius, options.suppression_radius));
    for (const std::uint32_t row : features::iss_keypoints(grid, options)) {
      keypoints.push_back(cloud->input_row(grid.original(row)));
    }
    std::sort(keypoints.begin(), keypoints.end());
    return keypoints;
  });
  return to_array(std::move(*rows));
}

/// Descriptors of some rows of the caller's array, ascending.
struct DescribedRows {
  std::vector<float> values;
  std::vector<std::int64_t> rows;
};

DescribedRows described_rows(const Cloud& cloud, const std::vector<std::uint8_t>& wanted, double radius,
                             double normal_radius, const Viewpoint& viewpoint) {
  const DescribedCloud described(cloud, radius, normal_radius, viewpoint);
  std::vector<std::uint32_t> grid_rows;
  for (std::uint32_t row = 0; row < described.grid.size(); ++row) {
    if (wanted[described.input_rows[row]] != 0) grid_rows.push_back(row);
  }
  const features::Descriptors found = features::fpfh(described.grid, grid_rows, radius);
  std::vector<std::size_t> order(found.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto input_row = [&](std::size_t k) { return described.input_rows[found.rows[k]]; };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return input_row(a) < input_row(b); });
  DescribedRows result;
  for (const std::size_t k : order) {
    result.rows.push_back(input_row(k));
    const auto first = found.values.begin() + static_cast<std::ptrdiff_t>(k * found.length);
    result.values.insert(result.values.end(), first, first + static_cast<std::ptrdiff_t>(found.length));
  }
  return result;
}

nb::tuple fpfh(ArrayLike points, double radius, double normal_radius, std::optional<ArrayLike> rows,
               const Viewpoint& viewpoint, std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  std::vector<std::uint8_t> wanted(cloud->size() + cloud->left_out(), rows ? 0 : 1);
  if (rows) {
    for (const std::uint32_t row : indices_from(*rows, "rows")) {
      if (row >= wanted.size()) {
        throw std::out_of_range("row " + std::to_string(row) + " of " + std::to_string(wanted.size()) + " points");
      }
      wanted[row] = 1;
    }
  }
  auto found = result_of(threads, [=] { return described_rows(*cloud, wanted, radius, normal_radius, viewpoint); });
  const std::size_t count = found->rows.size();
  return nb::make_tuple(to_array<Array<float, -1, 33>>(std::move(found->values), {count, 33}),
                        to_array(std::move(found->rows)));
}

using Descriptors = nb::ndarray<const float, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

nb::tuple match(const Descriptors& source, const Descriptors& target, std::size_t best, bool mutual, double ratio,
                std::optional<int> threads) {
  if (source.shape(1) != target.shape(1)) {
    throw nb::value_error("source and target have descriptors of different lengths");
  }
  const features::MatchOptions options{best, mutual, ratio};
  // Copies: work that is left behind at Ctrl-C may outlive the caller's arrays.
  const auto copied = [](const Descriptors& from) {
    return std::make_shared<const std::vector<float>>(from.data(), from.data() + from.size());
  };
  const auto found =
      result_of(threads, [a = copied(source), b = copied(target), length = static_cast<std::size_t>(source.shape(1)),
                          options] { return features::match(*a, *b, length, options); });
  std::vector<std::int64_t> pairs;
  std::vector<float> distances;
  distances.reserve(found->size());
  for (const features::Match& m : *found) {
    pairs.insert(pairs.end(), {m.source, m.target});
    distances.push_back(m.distance);
  }
  return nb::make_tuple(to_array<Array<std::int64_t, -1, 2>>(std::move(pairs), {found->size(), 2}),
                        to_array(std::move(distances)));
}

nb::tuple nearest_neighbours(ArrayLike points, ArrayLike queries, std::size_t most, double radius,
                             std::optional<double> missing, std::optional<int> threads) {
  const auto cloud = shared_cloud(points, "points", missing);
  Points asked(queries, "queries");
  asked.widen();
  const PointSpan<double> span = asked.span<double>();
  std::vector<std::array<double, 3>> places(span.size);
  for (std::size_t k = 0; k < span.size; ++k) places[k] = {span(k, 0), span(k, 1), span(k, 2)};
  checked_radius(radius);
  const auto found = result_of(threads, [=] {
    const features::CellGrid grid(*cloud, radius);
    features::NearestLists lists = features::nearest_neighbours(grid, places, most, radius);
    for (std::uint32_t& row : lists.rows) {
      if (row != features::NearestLists::kNone) row = cloud->input_row(grid.original(row));
    }
    return lists;
  });
  std::vector<std::int64_t> rows;
  rows.reserve(found->rows.size());
  for (const std::uint32_t row : found->rows) {
    rows.push_back(row == features::NearestLists::kNone ? std::int64_t{-1} : std::int64_t{row});
  }
  return nb::make_tuple(to_array<Array<std::int64_t, -1, -1>>(std::move(rows), {places.size(), most}),
                        to_array<Array<double, -1, -1>>(std::move(found->distances), {places.size(), most}));
}

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
  return nb::make_tuple(evidence->log10_chance, evidence->agreement, evidence->seen_through, evidence->samples,
                        evidence->displacements);
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
    fields["verdict"] = nb::make_tuple(evidence_fields(verdict->pose), evidence_fields(verdict->runner_up),
                                       verdict->log10_of_both, to_string(verdict->of_correspondences));
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

void bind_features(nb::module_& module) {
  module.def("voxel_grid", &voxel_grid, nb::arg("points"), nb::arg("voxel"), nb::arg("missing").none(),
             nb::arg("threads").none());
  module.def("farthest_subset", &farthest_subset, nb::arg("points"), nb::arg("count"), nb::arg("seed"),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("normals", &normals, nb::arg("points"), nb::arg("radius"), nb::arg("viewpoint").none(),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("iss_keypoints", &iss_keypoints, nb::arg("points"), nb::arg("radius"), nb::arg("suppression_radius"),
             nb::arg("second_to_first"), nb::arg("third_to_second"), nb::arg("fewest_neighbours"),
             nb::arg("missing").none(), nb::arg("threads").none());
  module.def("fpfh", &fpfh, nb::arg("points"), nb::arg("radius"), nb::arg("normal_radius"), nb::arg("rows").none(),
             nb::arg("viewpoint").none(), nb::arg("missing").none(), nb::arg("threads").none());
  module.def("match", &match, nb::arg("source"), nb::arg("target"), nb::arg("best"), nb::arg("mutual"),
             nb::arg("ratio"), nb::arg("threads").none());
  module.def("nearest_neighbours", &nearest_neighbours, nb::arg("points"), nb::arg("queries"), nb::arg("most"),
             nb::arg("radius"), nb::arg("missing").none(), nb::arg("threads").none());
  module.def("refine", &refine, nb::arg("source"), nb::arg("target"), nb::arg("pose"), nb::arg("method"),
             nb::arg("voxel").none(), nb::arg("normal_radius"), nb::arg("cell_radius"), nb::arg("max_distance").none(),
             nb::arg("max_iterations"), nb::arg("missing").none(), nb::arg("threads").none());
  bind_on_clouds(module, "match_clouds", &match_clouds, nb::arg("threads").none());
  bind_on_clouds(module, "register_clouds", &register_clouds, nb::arg("noise_bound").none(), nb::arg("solver"),
                 nb::arg("verify"), nb::arg("refine").none(), nb::arg("threads").none(), nb::arg("time_limit").none());
}

}  // namespace consimd::python
