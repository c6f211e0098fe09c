// ETH's terrestrial laser scans (Theiler, Wegner, Schindler, ISPRS J. 2015), a pose a pair.
#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/problem_files.hpp>

#include "scans/layouts.hpp"

namespace consimd::studies::detail {
namespace fs = std::filesystem;
namespace {

constexpr PoseLimits kPaperLimits{5.0, 0.5};

bool is_pose_file(const fs::path& path) {
  return path.extension() == ".pose" && path.stem().string().find('-') != std::string::npos;
}

/// "s2", of s2.ply or of s2_v0.1_sor.pcd: what a cloud's name begins with.
fs::path scan_file(const fs::path& scene, const std::vector<fs::path>& files, const std::string& scan,
                   const fs::path& pose) {
  if (const std::optional<fs::path> exact = cloud_file(scene, scan)) return *exact;
  std::vector<fs::path> found;
  for (const fs::path& path : files) {
    if (is_cloud_file(path) && path.filename().string().starts_with(scan + "_")) found.push_back(path);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    throw std::runtime_error(
        fmt::format("{}: is missing, which {} names", (scene / (scan + ".EXT")).string(), pose.filename().string()));
  }
  throw std::runtime_error(fmt::format("{}: {} and {} may both be scan {}", scene.string(),
                                       found[0].filename().string(), found[1].filename().string(), scan));
}

ScanGroup read_scene(const fs::path& scene) {
  const std::string name = name_of(scene);
  ScanGroup group{
      .name = "ETH " + name, .dataset = "ETH", .sequence = name, .provenance = "scans of ETH's data set", .pairs = {}};
  const std::vector<fs::path> files = files_in(scene);
  for (const fs::path& path : files) {
    if (!is_pose_file(path)) continue;
    const std::string stem = path.stem().string();
    const std::size_t between = stem.find('-');
    const RigidTransform pose = synth::read_pose(path);
    group.pairs.push_back({.name = stem,
                           .source = scan_file(scene, files, stem.substr(0, between), path),
                           .target = scan_file(scene, files, stem.substr(between + 1), path),
                           .T_target_source = pose,
                           .limits = kPaperLimits});
  }
  return group;
}

/// Whether some are clouds for certain: other things are text as well.
bool has_clouds(const std::vector<fs::path>& files) {
  return std::ranges::any_of(files, [](const fs::path& path) {
    return is_cloud_file(path) && path.extension() != ".txt" && path.extension() != ".csv";
  });
}

}  // namespace

ScanList read_eth(const LayoutOptions& options) {
  ScanList list;
  const fs::path root = options.folder;
  std::vector<fs::path> scenes = folders_in(root);
  if (std::ranges::any_of(files_in(root), is_pose_file)) scenes = {root};  // one scene
  for (const fs::path& scene : scenes) {
    if (!wanted(options, name_of(scene))) continue;
    const std::vector<fs::path> files = files_in(scene);
    const bool named = !options.sequences.empty();
    if (!std::ranges::any_of(files, is_pose_file)) {
      if (!named && !has_clouds(files)) continue;  // no scene at all
      throw std::runtime_error(
          fmt::format("{}: is missing: a scene has a pose of each pair", (scene / "SOURCE-TARGET.pose").string()));
    }
    list.groups.push_back(read_scene(scene));
  }
  if (list.groups.empty() && options.sequences.empty()) {
    throw std::runtime_error(
        fmt::format("{}: holds no scene, a folder with scans and SOURCE-TARGET.pose files", root.string()));
  }
  return list;
}

}  // namespace consimd::studies::detail
