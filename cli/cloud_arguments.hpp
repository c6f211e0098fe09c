// Clouds on the command line: what becomes of two files of points.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include <consimd/features/cloud_matching.hpp>

namespace consimd::cli {

/// The forms of clouds that are read, for help.
inline constexpr const char* kCloudForms = "PLY, PCD, NPY, NPZ, LAS, KITTI's .bin, or text with x y z a line";

struct CloudArguments {
  std::optional<double> voxel;
  std::string keypoints = "random:5000";
  std::string matches = "mutual:3";
  std::optional<double> missing;
  std::string target_viewpoint = "0,0,0";
  std::string save_correspondences;
  // What only `register` takes.
  bool no_verification = false;
  std::optional<std::string> refine;
  std::string save_aligned;
  // What correspondences take as well.
  std::string source_viewpoint = "0,0,0";

  /// Whether any of them was given.
  [[nodiscard]] bool given() const;
};

/// X,Y,Z, or nothing where the text is "none". Throws std::invalid_argument that names the option on other text.
[[nodiscard]] std::optional<std::array<double, 3>> viewpoint_of(const char* option, const std::string& text);

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

/// For people: what was chosen, and a line per stage.
[[nodiscard]] std::string to_text(const features::CloudMatches& matches, const CloudArguments& arguments);

}  // namespace consimd::cli
