#include <consimd/features/cloud_matching.hpp>

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include <consimd/features/cell_grid.hpp>
#include <consimd/features/fpfh.hpp>
#include <consimd/features/iss.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/point_subset.hpp>
#include <consimd/features/voxel_grid.hpp>

#include "grid/box.hpp"
#include "grid/neighbourhoods.hpp"

namespace consimd::features {
namespace {

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

void require_points(const Cloud& cloud, const std::string& name) {
  if (!cloud.empty()) return;
  throw std::invalid_argument(
      "the " + name + " cloud is empty" +
      (cloud.left_out() > 0 ? ": all of its " + std::to_string(cloud.left_out()) + " rows are without a place" : ""));
}

void require_radii(const CloudMatchingOptions& options) {
  if (!(std::isfinite(options.descriptor_radius) && options.descriptor_radius > 0.0)) {
    throw std::invalid_argument("descriptor_radius is " + std::to_string(options.descriptor_radius) +
                                ", expected a number of voxels above 0");
  }
  for (const auto& [name, radius] :
       {std::pair("normal_radius", options.normal_radius), std::pair("iss_radius", options.iss_radius),
        std::pair("iss_suppression_radius", options.iss_suppression_radius)}) {
    if (radius > 0.0 && radius <= options.descriptor_radius) continue;
    if (!options.iss && name != std::string("normal_radius")) continue;
    throw std::invalid_argument(name + (" is " + std::to_string(radius)) +
                                ", expected a number of voxels above 0, at most descriptor_radius, " +
                                std::to_string(options.descriptor_radius));
  }
}

std::string hint_of(double source_extent, double target_extent) {
  for (const auto& [name, length] : {std::pair("source", source_extent), std::pair("target", target_extent)}) {
    if (length == 0.0) return std::string("all points of the ") + name + " cloud lie in one place";
  }
  constexpr double kLargestRatio = 100.0;
  const double ratio = std::max(source_extent, target_extent) / std::min(source_extent, target_extent);
  if (!(ratio > kLargestRatio)) return {};
  const bool source_larger = source_extent > target_extent;
  return std::string("the ") + (source_larger ? "source" : "target") + " cloud is " + shown(ratio) +
         " times as long as the other: are both in the same unit?";
}

/// Names a voxel that suits the clouds, where theirs are so small that hardly any has others within the radii that go
/// with them; empty otherwise.
std::string hint_of_small_voxels(const Cloud& source, const Cloud& target, const CloudMatches& found) {
  if (found.source.descriptors > 0 && found.target.descriptors > 0) return {};
  const double suited = std::max(choose_voxel(source), choose_voxel(target));
  if (suited <= found.voxel) return {};
  return "of " + std::to_string(found.source.voxels) + " and " + std::to_string(found.target.voxels) +
         " voxels hardly any has others near it: a voxel of " + shown(found.voxel) + " is too small, " + shown(suited) +
         " would suit the clouds";
}

double voxel_of(const Cloud& source, const Cloud& target, const CloudMatchingOptions& options) {
  if (!options.voxel) return std::max(choose_voxel(source), choose_voxel(target));
  const double longest = std::max(detail::extent(source), detail::extent(target));
  if (!std::isfinite(*options.voxel) || *options.voxel <= 0.0 || (longest > 0.0 && *options.voxel > longest)) {
    throw std::invalid_argument("voxel is " + shown(*options.voxel) + ", expected a length above 0 and below " +
                                shown(longest) + ", that of the clouds; " +
                                shown(std::max(choose_voxel(source), choose_voxel(target))) + " would suit them");
  }
  return *options.voxel;
}

/// What is made of one cloud on the way.
struct Side {
  const Cloud& cloud;
  const std::optional<std::array<double, 3>>& viewpoint;
  CloudSummary& summary;
  std::optional<CellGrid> grid = std::nullopt;
  std::vector<std::uint32_t> keypoints = {};  ///< of the grid, to draw from
  Descriptors descriptors = {};
};

/// Some of the side's keypoints, ascending.
std::vector<std::uint32_t> drawn(const Side& side, const CloudMatchingOptions& options) {
  const std::vector<std::uint32_t>& rows = side.keypoints;
  const std::size_t count = options.keypoints.value_or(rows.size());
  std::vector<std::uint32_t> chosen;
  if (options.farthest && count < rows.size()) {
    chosen = farthest_subset(side.grid->cloud().subset(rows), count, options.seed);
    std::sort(chosen.begin(), chosen.end());
  } else {
    chosen = random_subset(rows.size(), count, options.seed);
  }
  for (std::uint32_t& row : chosen) row = rows[row];
  return chosen;
}

/// Runs the stages one after another, each on both clouds at the same time.
class Stages {
 public:
  Stages(Side& source, Side& target, std::vector<StageReport>& reports)
      : source_(source), target_(target), reports_(reports) {}

  /// work(side) gives what went in and what came out.
  template <typename Work>
  void run(const char* name, const Work& work) {
    time(name, [&] {
      std::pair<std::size_t, std::size_t> source, target;
      tbb::parallel_invoke([&] { source = work(source_); }, [&] { target = work(target_); });
      return std::pair(source.first + target.first, source.second + target.second);
    });
  }

  template <typename Work>
  void time(const char* name, const Work& work) {
    const auto start = std::chrono::steady_clock::now();
    const auto [input, output] = work();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    reports_.push_back({name, input, output, 0, taken.count()});
  }

 private:
  Side& source_;
  Side& target_;
  std::vector<StageReport>& reports_;
};

double noise_bound_of(const CloudMatches& matches) {
  constexpr double kResolutions = 3.0;
  const double mean = (matches.source.resolution + matches.target.resolution) / 2.0;
  return kResolutions * (std::isfinite(mean) && mean > 0.0 ? mean : matches.voxel);
}

void take_points(const Side& source, const Side& target, CloudMatches& result) {
  for (const Match& m : result.matches) {
    result.source_points.push_back(source.grid->cloud().point(source.descriptors.rows[m.source]));
    result.target_points.push_back(target.grid->cloud().point(target.descriptors.rows[m.target]));
  }
  const auto span = [](const std::vector<std::array<double, 3>>& points) {
    return PointSpan<double>::interleaved(points.empty() ? nullptr : points.front().data(), points.size());
  };
  result.correspondences = Correspondences(span(result.source_points), span(result.target_points));
  if (source.viewpoint) result.correspondences.set_source_viewpoint(*source.viewpoint);
}

}  // namespace

CloudMatches match_clouds(const Cloud& source, const Cloud& target, const CloudMatchingOptions& options) {
  require_points(source, "source");
  require_points(target, "target");
  require_radii(options);
  CloudMatches result;
  Side of_source{source, options.source_viewpoint, result.source};
  Side of_target{target, options.target_viewpoint, result.target};
  Stages stages(of_source, of_target, result.stages);

  if (!options.voxel) {
    stages.time("choose_voxel", [&] {
      result.voxel = voxel_of(source, target, options);
      return std::pair(source.size() + target.size(), source.size() + target.size());
    });
  } else {
    result.voxel = voxel_of(source, target, options);
  }
  result.hint = hint_of(detail::extent(source), detail::extent(target));
  const double radius = options.descriptor_radius * result.voxel;

  stages.run("voxel_grid", [&](Side& side) {
    side.grid.emplace(voxel_grid(side.cloud, result.voxel), radius);
    side.summary.points = side.cloud.size();
    side.summary.left_out = side.cloud.left_out();
    side.summary.voxels = side.grid->size();
    side.summary.resolution = resolution(*side.grid);
    return std::pair(side.cloud.size(), side.grid->size());
  });
  stages.run("normals", [&](Side& side) {
    estimate_normals(*side.grid, {options.normal_radius * result.voxel, side.viewpoint});
    return std::pair(side.grid->size(), side.grid->size());
  });
  if (options.iss) {
    stages.run("iss", [&](Side& side) {
      side.keypoints = iss_keypoints(*side.grid, {.radius = options.iss_radius * result.voxel,
                                                  .suppression_radius = options.iss_suppression_radius * result.voxel});
      return std::pair(side.grid->size(), side.keypoints.size());
    });
  } else {
    for (Side* side : {&of_source, &of_target}) side->keypoints = detail::all_rows(side->grid->size());
  }
  if (options.farthest) {
    stages.run("farthest", [&](Side& side) {
      const std::size_t before = side.keypoints.size();
      side.keypoints = drawn(side, options);
      return std::pair(before, side.keypoints.size());
    });
  }
  stages.run("fpfh", [&](Side& side) {
    side.descriptors = fpfh(*side.grid, options.farthest ? side.keypoints : drawn(side, options), radius);
    side.summary.descriptors = side.descriptors.size();
    return std::pair(side.grid->size(), side.descriptors.size());
  });
  if (options.voxel && !options.iss && result.hint.empty()) result.hint = hint_of_small_voxels(source, target, result);
  stages.time("matches", [&] {
    result.matches = match(of_source.descriptors.values, of_target.descriptors.values, of_source.descriptors.length,
                           options.matches);
    return std::pair(of_source.descriptors.size() + of_target.descriptors.size(), result.matches.size());
  });
  result.noise_bound = noise_bound_of(result);
  take_points(of_source, of_target, result);
  result.source_voxels = std::make_shared<const CellGrid>(std::move(*of_source.grid));
  result.target_voxels = std::make_shared<const CellGrid>(std::move(*of_target.grid));
  return result;
}

}  // namespace consimd::features
