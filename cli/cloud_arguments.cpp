#include "cloud_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <consimd/features/cloud_files.hpp>

#include "text/words.hpp"

namespace consimd::cli {
namespace {

/// NAME:NUMBER, the number from 1 to `most`.
std::optional<std::size_t> number_after(std::string_view text, std::string_view name, std::size_t most) {
  if (!text.starts_with(name) || text.size() <= name.size() || text[name.size()] != ':') return std::nullopt;
  text.remove_prefix(name.size() + 1);
  const auto value = text::number_in<std::size_t>(text);
  return value && *value >= 1 && *value <= most ? value : std::nullopt;
}

void choose_keypoints(const std::string& text, features::CloudMatchingOptions& options) {
  constexpr std::size_t kMost = 0xffffffff;
  const auto chosen = [&](std::string_view name) { return options.keypoints = number_after(text, name, kMost); };
  if (text == "all" || text == "iss") {
    options.keypoints = std::nullopt;
    options.iss = text == "iss";
  } else if (chosen("farthest")) {
    options.farthest = true;
  } else if (chosen("iss")) {
    options.iss = true;
  } else if (!chosen("random")) {
    throw std::invalid_argument(
        fmt::format("--keypoints: expected all, random:COUNT, farthest:COUNT, iss or iss:COUNT, got '{}'", text));
  }
}

features::MatchOptions matches_of(const std::string& text) {
  constexpr std::size_t kMost = 8;
  if (const auto best = number_after(text, "mutual", kMost)) return {.best = *best, .mutual = true};
  if (const auto best = number_after(text, "nearest", kMost)) return {.best = *best, .mutual = false};
  throw std::invalid_argument(fmt::format("--matches: expected mutual:K or nearest:K, K from 1 to 8, got '{}'", text));
}

/// X,Y,Z, or nothing where the text is something else.
Viewpoint place_of(const std::string& text) {
  const std::vector<std::string_view> parts = text::split(text, ',');
  std::array<double, 3> place{};
  if (parts.size() != place.size()) return std::nullopt;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto value = text::number_in<double>(parts[axis]);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    place[axis] = *value;
  }
  return place;
}

Viewpoint cloud_viewpoint(const char* option, const std::optional<std::string>& text) {
  if (!text) return std::array{0.0, 0.0, 0.0};
  if (text == "none") return std::nullopt;
  if (const Viewpoint place = place_of(*text)) return place;
  throw std::invalid_argument(fmt::format("{}: expected X,Y,Z or none, got '{}'", option, *text));
}

/// Whole numbers from 1 on, between commas, each three of them of one point: different ones; none of other text.
std::vector<std::size_t> columns_in(std::string_view list) {
  constexpr std::size_t kMost = 1'000'000;
  std::vector<std::size_t> columns;
  for (const std::string_view part : text::split(list, ',')) {
    const std::size_t column = text::number_in<std::size_t>(part).value_or(0);
    const std::size_t of_point = columns.size() % 3;
    const bool is_there =
        std::find(columns.end() - static_cast<std::ptrdiff_t>(of_point), columns.end(), column) != columns.end();
    if (column < 1 || column > kMost || is_there) return {};
    columns.push_back(column);
  }
  return columns;
}

}  // namespace

std::vector<std::size_t> row_columns_of(const CloudArguments& arguments) {
  if (!arguments.columns) return {};
  std::vector<std::size_t> columns = columns_in(*arguments.columns);
  if (columns.size() == 6) return columns;
  throw std::invalid_argument(
      fmt::format("--columns: expected six columns counted from 1, as in 2,3,4,5,6,7, none twice of a point, got '{}'",
                  *arguments.columns));
}

Viewpoint source_viewpoint_of(const CloudArguments& arguments) {
  return cloud_viewpoint("--source-viewpoint", arguments.source_viewpoint);
}

Viewpoint target_viewpoint_of(const CloudArguments& arguments) {
  return cloud_viewpoint("--target-viewpoint", arguments.target_viewpoint);
}

Viewpoint row_viewpoint_of(const CloudArguments& arguments) {
  const std::optional<std::string>& text = arguments.source_viewpoint;
  if (!text) return std::nullopt;
  if (const Viewpoint place = place_of(*text)) return place;
  throw std::invalid_argument(
      fmt::format("--source-viewpoint: expected X,Y,Z of correspondences, got '{}'{}", *text,
                  text == "none" ? ", which is of clouds: leave the option out for the origin" : ""));
}

std::optional<features::PairColumns> pair_columns_of(const CloudArguments& arguments) {
  if (!arguments.columns) return std::nullopt;
  const std::vector<std::size_t> chosen = columns_in(*arguments.columns);
  if (chosen.size() != 3 && chosen.size() != 6) {
    throw std::invalid_argument(
        fmt::format("--columns: expected three columns of both clouds counted from 1, as in 2,3,4, or six, three of "
                    "each, got '{}'",
                    *arguments.columns));
  }
  features::PairColumns columns{};
  for (std::size_t k = 0; k < 6; ++k) columns[k / 3][k % 3] = chosen[k % chosen.size()];
  return columns;
}

void add_columns_option(CLI::App& command, CloudArguments& arguments, const std::string& help) {
  command.add_option("--columns", arguments.columns, help);
}

std::vector<std::string> CloudArguments::given() const {
  const CloudArguments defaults;
  std::vector<std::string> options;
  const auto add = [&](bool is_given, const char* option, const auto& value) {
    if (is_given) options.push_back(fmt::format("{} {}", option, value));
  };
  add(voxel.has_value(), "--voxel", voxel.value_or(0.0));
  add(keypoints != defaults.keypoints, "--keypoints", keypoints);
  add(matches != defaults.matches, "--matches", matches);
  add(missing.has_value(), "--missing", missing.value_or(0.0));
  add(target_viewpoint.has_value(), "--target-viewpoint", target_viewpoint.value_or(""));
  add(!save_correspondences.empty(), "--save-correspondences", save_correspondences);
  if (no_verification) options.emplace_back("--no-verification");
  add(refine.has_value(), "--refine", refine.value_or(""));
  add(!save_aligned.empty(), "--save-aligned", save_aligned);
  return options;
}

void add_cloud_options(CLI::App& command, CloudArguments& arguments) {
  command.add_option("--voxel", arguments.voxel,
                     "Of clouds: side of the voxels that they are thinned out with, in their unit. Chosen such that a "
                     "cloud has about 12000 of them when not given");
  command
      .add_option(
          "--keypoints", arguments.keypoints,
          "Of clouds: the points that are described and matched: random:COUNT of each cloud, farthest:COUNT, each as "
          "far as can be from those before, iss, its ISS keypoints, or iss:COUNT of them at random, or all")
      ->capture_default_str();
  command
      .add_option("--matches", arguments.matches,
                  "Of clouds: mutual:K, pairs among each other's K nearest descriptors, or nearest:K, the K nearest of "
                  "each source point; K from 1 to 8")
      ->capture_default_str();
  command.add_option("--missing", arguments.missing,
                     "Of clouds: a point whose three coordinates are this number is none, as depth cameras write it");
  command
      .add_option("--source-viewpoint", arguments.source_viewpoint,
                  "Where the source was scanned from, X,Y,Z in its own frame: matches tend to keep the range about the "
                  "sensor, and surfaces of a cloud are turned to it. Of clouds also none, and they are turned up")
      ->default_str("0,0,0");
  command
      .add_option(
          "--target-viewpoint", arguments.target_viewpoint,
          "Of clouds: the same of the target, X,Y,Z or none. Of a map of many scans none, and of what is registered to "
          "it too: surfaces that are turned in different ways do not match")
      ->default_str("0,0,0");
}

void add_refinement_options(CLI::App& command, CloudArguments& arguments) {
  command.add_option(
      "--refine", arguments.refine,
      "Of clouds: refine the pose on their voxels by iterative closest points: distances to points "
      "(point), to the target's planes (plane), or between planes (gicp). The status and the inliers stay "
      "as they were");
  command.add_option("--save-aligned", arguments.save_aligned,
                     "Of clouds: write all points of SOURCE, moved by the pose if there is one, to this PLY file");
}

features::CloudMatchingOptions matching_options(const CloudArguments& arguments, std::uint64_t seed) {
  features::CloudMatchingOptions options{.voxel = arguments.voxel,
                                         .matches = matches_of(arguments.matches),
                                         .seed = seed,
                                         .source_viewpoint = source_viewpoint_of(arguments),
                                         .target_viewpoint = target_viewpoint_of(arguments)};
  choose_keypoints(arguments.keypoints, options);
  return options;
}

CloudPair read_clouds(const std::string& source, const std::string& target, const CloudArguments& arguments) {
  if (source == "-" && target == "-") {
    throw std::invalid_argument("SOURCE and TARGET are both '-': the standard input holds one cloud");
  }
  const std::optional<features::PairColumns> columns = pair_columns_of(arguments);
  const auto read = [&](const std::string& file, std::size_t side) {
    Cloud cloud =
        features::read_cloud(file, arguments.missing, columns ? std::optional((*columns)[side]) : std::nullopt);
    if (!cloud.empty()) return cloud;
    const std::string left_out =
        cloud.left_out() > 0 ? fmt::format(": all of its {} rows are without a place", cloud.left_out()) : "";
    throw std::runtime_error(fmt::format("{}: holds no points{}", file, left_out));
  };
  return {read(source, 0), read(target, 1)};
}

std::string correspondence_text(const features::CloudMatches& matches) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "# source x y z, target x y z\n");
  for (std::size_t k = 0; k < matches.matches.size(); ++k) {
    const auto& p = matches.source_points[k];
    const auto& q = matches.target_points[k];
    fmt::format_to(out, "{} {} {} {} {} {}\n", p[0], p[1], p[2], q[0], q[1], q[2]);
  }
  return fmt::to_string(text);
}

std::string to_text(const features::CloudMatches& matches, const CloudArguments& arguments, bool bound_is_given) {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  for (const auto& [name, cloud] : {std::pair("source", &matches.source), std::pair("target", &matches.target)}) {
    fmt::format_to(out, "{:<14}{} points", name, cloud->points);
    if (cloud->left_out > 0) fmt::format_to(out, " ({} rows left out, without a place or far off)", cloud->left_out);
    fmt::format_to(out, ", {} voxels, {} described, resolution {:.3g}\n", cloud->voxels, cloud->descriptors,
                   cloud->resolution);
  }
  fmt::format_to(out, "voxel         {:.4g}, keypoints {}, matches {}", matches.voxel, arguments.keypoints,
                 arguments.matches);
  if (!bound_is_given) fmt::format_to(out, "; noise bound by the resolution {:.4g}", matches.noise_bound);
  fmt::format_to(out, "\n");
  if (!matches.hint.empty()) fmt::format_to(out, "hint          {}\n", matches.hint);
  fmt::format_to(out, "{:<24}{:>10}{:>10}{:>12}{:>12}\n", "stage", "input", "output", "", "ms");
  for (const StageReport& stage : matches.stages) {
    fmt::format_to(out, "{:<24}{:>10}{:>10}{:>12}{:>12.3f}\n", stage.name, stage.input, stage.output, "",
                   1e3 * stage.seconds);
  }
  return fmt::to_string(text);
}

}  // namespace consimd::cli
