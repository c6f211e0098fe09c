#include <consimd/studies/scan_layout.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/features/point_subset.hpp>

#include "scans/layouts.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr ScanLayout kLayouts[] = {
    {"kitti", "KITTI odometry: sequences/NN/velodyne/*.bin, sequences/NN/calib.txt, poses/NN.txt"},
    {"eth", "ETH's terrestrial scans: SCENE/A.EXT or SCENE/A_*.EXT, SCENE/A-B.pose of each pair"},
    {"3dmatch", "3DMatch, 3DLoMatch: SCENE/cloud_bin_N.EXT, gt.log in SCENE or SCENE-evaluation"},
    {"pairs", "yours: pairs.csv with the columns source, target, pose"},
};

// Of clouds that features::read_cloud reads.
constexpr std::string_view kCloudEndings[] = {".ply", ".pcd", ".npy", ".npz", ".las", ".bin",
                                              ".xyz", ".pts", ".asc", ".csv", ".txt"};

void require_known_layout(std::string_view name) {
  if (std::ranges::find(kLayouts, name, &ScanLayout::name) != std::end(kLayouts)) return;
  std::vector<std::string_view> known;
  for (const ScanLayout& layout : kLayouts) known.push_back(layout.name);
  if (name.empty()) {
    throw std::invalid_argument(fmt::format("layout: of scans it is needed: one of {}", fmt::join(known, ", ")));
  }
  throw std::invalid_argument(fmt::format("layout: '{}' is none of {}", name, fmt::join(known, ", ")));
}

/// Options of a layout that is not the one asked for would do nothing.
void require_own_options(const LayoutOptions& options) {
  const auto refuse = [&](bool given, std::string_view option, std::string_view layout) {
    if (!given || options.layout == layout) return;
    throw std::invalid_argument(fmt::format("{}: it is for the layout {}, not {}", option, layout, options.layout));
  };
  refuse(options.distance != LayoutOptions().distance, "distance", "kitti");
  refuse(!options.pair_list.empty(), "pair list", "kitti");
  refuse(!options.ground_truth.empty(), "ground truth", "3dmatch");
  refuse(options.overlap.has_value(), "overlap", "3dmatch");
  refuse(options.skip_consecutive, "skip consecutive", "3dmatch");
}

void validate(const LayoutOptions& options) {
  require_known_layout(options.layout);
  require_own_options(options);
  if (options.pairs == 0U) throw std::invalid_argument("pairs: expected at least 1, got 0");
  const bool is_length = std::isfinite(options.distance) && options.distance > 0.0;
  if (!is_length) {
    throw std::invalid_argument(fmt::format("distance: expected a length above 0, got {}", options.distance));
  }
  if (!options.pair_list.empty() && (options.distance != LayoutOptions().distance)) {
    throw std::invalid_argument("distance: a pair list tells which pairs there are");
  }
  if (options.overlap) {
    const auto [least, most] = *options.overlap;
    const bool are_shares = least >= 0.0 && least < most && most <= 1.0;
    if (!are_shares) {
      throw std::invalid_argument(
          fmt::format("overlap: expected two shares in [0, 1], the lower one first, got {}:{}", least, most));
    }
  }
  std::error_code ignored;
  const bool is_table = options.layout == "pairs" && fs::is_regular_file(options.folder, ignored);
  if (!is_table && !fs::is_directory(options.folder, ignored)) {
    throw std::runtime_error(fmt::format("{}: no such folder", options.folder));
  }
}

void require_all_found(const LayoutOptions& options, const ScanList& list) {
  for (auto wanted = options.sequences.begin(); wanted != options.sequences.end(); ++wanted) {
    if (std::find(options.sequences.begin(), wanted, *wanted) != wanted) {
      throw std::invalid_argument(fmt::format("sequences: {} is given twice", *wanted));
    }
    if (std::ranges::find(list.groups, *wanted, &ScanGroup::sequence) != list.groups.end()) continue;
    throw std::runtime_error(fmt::format("{}: has no sequence, scene or group '{}'", options.folder, *wanted));
  }
}

}  // namespace

std::span<const ScanLayout> scan_layouts() noexcept { return kLayouts; }

ScanList read_scan_list(const LayoutOptions& options, bool with_information) {
  validate(options);
  ScanList list = options.layout == "kitti"     ? detail::read_kitti(options)
                  : options.layout == "eth"     ? detail::read_eth(options)
                  : options.layout == "3dmatch" ? detail::read_3dmatch(options, with_information)
                                                : detail::read_pair_table(options);
  require_all_found(options, list);
  for (ScanGroup& group : list.groups) {
    if (group.pairs.empty()) throw std::runtime_error(fmt::format("{}: {} has no pairs", options.folder, group.name));
    detail::keep_some(group.pairs, options);
    for (const ScanPair& pair : group.pairs) {
      detail::require_file(pair.source);
      detail::require_file(pair.target);
    }
  }
  return list;
}

features::CloudMatchingOptions layout_front_end(std::string_view layout) {
  require_known_layout(layout);
  if (layout == "kitti") return {.voxel = 0.3};
  if (layout == "eth") return {.voxel = 0.1, .keypoints = std::nullopt, .iss = true};
  if (layout == "3dmatch") return {.voxel = 0.05};
  return {};
}

namespace detail {

std::string name_of(const fs::path& folder) {
  std::error_code ignored;
  const fs::path whole = fs::weakly_canonical(folder, ignored);
  return (whole / "").parent_path().filename().string();
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::error_code error, ignored;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(ignored)) found.push_back(entry.path());
  }
  if (error) throw std::runtime_error(fmt::format("{}: cannot read: {}", folder.string(), error.message()));
  std::ranges::sort(found);
  return found;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::error_code error, ignored;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!entry.is_directory(ignored)) found.push_back(entry.path());
  }
  if (error) throw std::runtime_error(fmt::format("{}: cannot read: {}", folder.string(), error.message()));
  std::ranges::sort(found);
  return found;
}

std::optional<fs::path> cloud_file(const fs::path& folder, std::string_view stem) {
  std::error_code ignored;
  for (const std::string_view ending : kCloudEndings) {
    fs::path path = folder / fmt::format("{}{}", stem, ending);
    if (fs::exists(path, ignored)) return path;
  }
  return std::nullopt;
}

bool is_cloud_file(const fs::path& path) {
  return std::ranges::find(kCloudEndings, path.extension().string()) != std::end(kCloudEndings);
}

bool wanted(const LayoutOptions& options, std::string_view sequence) {
  return options.sequences.empty() || std::ranges::find(options.sequences, sequence) != options.sequences.end();
}

void require_file(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw std::runtime_error(fmt::format("{}: is missing", path.string()));
  if (fs::is_directory(path, ignored)) {
    throw std::runtime_error(fmt::format("{}: is a folder, expected a file", path.string()));
  }
}

void keep_some(std::vector<ScanPair>& pairs, const LayoutOptions& options) {
  if (!options.pairs || pairs.size() <= *options.pairs) return;
  std::vector<ScanPair> kept;
  for (const std::uint32_t row : features::random_subset(pairs.size(), *options.pairs, options.seed)) {
    kept.push_back(std::move(pairs[row]));
  }
  pairs = std::move(kept);
}

}  // namespace detail
}  // namespace consimd::studies
