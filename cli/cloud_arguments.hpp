// Clouds on the command line: what becomes of two files of points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/correspondence_files.hpp>

namespace consimd::cli {

/// The forms of clouds that are read, for help.
inline constexpr const char* kCloudForms = "PLY, PCD, NPY, NPZ, LAS, KITTI's .bin, or text with x y z a line";

struct CloudArguments {
  std::optional<double> voxel;
  std::string keypoints = "random:5000";
  std::string matches = "mutual:3";
  std::optional<double> missing;
  std::optional<std::string> target_viewpoint;
  std::string save_correspondences;
  // What only `register` takes.
  bool no_verification = false;
  std::optional<std::string> refine;
  std::string save_aligned;
  // What correspondences take as well.
  std::optional<std::string> source_viewpoint;
  std::optional<std::string> columns;

  /// Those that were given and are of clouds alone, each with its value.
  [[nodiscard]] std::vector<std::string> given() const;
};

using Viewpoint = std::optional<std::array<double, 3>>;

/// Where the clouds were scanned from: the origins of their frames where nothing was given, nowhere if "none" was.
/// Throws std::invalid_argument that names the option on other text than X,Y,Z.
[[nodiscard]] Viewpoint source_viewpoint_of(const CloudArguments& arguments);
[[nodiscard]] Viewpoint target_viewpoint_of(const CloudArguments& arguments);

/// Gives that of the source of correspondences, if there is one. Throws as above, also on "none".
[[nodiscard]] Viewpoint row_viewpoint_of(const CloudArguments& arguments);

/// The columns of a file of correspondences, six, or none. Throws std::invalid_argument on others.
[[nodiscard]] std::vector<std::size_t> row_columns_of(const CloudArguments& arguments);

/// The columns of two clouds, if they were chosen: three, of both, or six. Throws std::invalid_argument on others.
[[nodiscard]] std::optional<features::PairColumns> pair_columns_of(const CloudArguments& arguments);

void add_columns_option(CLI::App& command, CloudArguments& arguments, const std::string& help);

void add_cloud_options(CLI::App& command, CloudArguments& arguments);

/// Throws std::invalid_argument that names the option unless all of them can be.
[[nodiscard]] features::CloudMatchingOptions matching_options(const CloudArguments& arguments, std::uint64_t seed);

struct CloudPair {
  Cloud source;
  Cloud target;
};

/// Throws as `read_cloud`, and std::invalid_argument where both are the standard input.
[[nodiscard]] CloudPair read_clouds(const std::string& source, const std::string& target,
                                    const CloudArguments& arguments);

/// The matches as lines of six numbers, as `consimd register` reads them.
[[nodiscard]] std::string correspondence_text(const features::CloudMatches& matches);

/// The options of what happens once there is a pose.
void add_refinement_options(CLI::App& command, CloudArguments& arguments);

/// For people: what was chosen, and a line per stage. `bound_is_given`: that of the resolution is not used.
[[nodiscard]] std::string to_text(const features::CloudMatches& matches, const CloudArguments& arguments,
                                  bool bound_is_given = false);

}  // namespace consimd::cli
