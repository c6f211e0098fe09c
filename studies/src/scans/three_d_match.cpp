// Fragments of 3DMatch (Zeng et al., CVPR 2017) and 3DLoMatch (Huang et al., CVPR 2021) with gt.log and gt.info, the
// files of Choi, Zhou, Koltun, CVPR 2015.
#include <algorithm>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "scans/layouts.hpp"
#include "scans/text_rows.hpp"

namespace consimd::studies::detail {
namespace fs = std::filesystem;
namespace {

constexpr PoseLimits kCustomaryLimits{15.0, 0.3};
constexpr std::string_view kPrefixes[] = {"cloud_bin_", "Hokuyo_"};

using Numbers = std::pair<std::uint32_t, std::uint32_t>;  // target i and source j, as the files have them

bool is_fragment(const fs::path& path) {
  const std::string name = path.filename().string();
  return is_cloud_file(path) &&
         std::ranges::any_of(kPrefixes, [&](std::string_view prefix) { return name.starts_with(prefix); });
}

bool is_scene(const fs::path& folder) { return std::ranges::any_of(files_in(folder), is_fragment); }

fs::path fragment_file(const fs::path& scene, std::uint32_t number) {
  for (const std::string_view prefix : kPrefixes) {
    if (const auto path = cloud_file(scene, fmt::format("{}{}", prefix, number))) return *path;
  }
  throw std::runtime_error(
      fmt::format("{}: is missing, which gt.log names", (scene / fmt::format("cloud_bin_{}.ply", number)).string()));
}

/// Where the scene's gt.log lies.
fs::path ground_truth_folder(const fs::path& scene, const LayoutOptions& options) {
  const std::string name = name_of(scene), evaluation = name + "-evaluation";
  std::vector<fs::path> places;
  if (options.ground_truth.empty()) {
    places = {scene, scene / evaluation, scene / ".." / evaluation};
  } else {
    places = {fs::path(options.ground_truth) / name, fs::path(options.ground_truth) / evaluation};
  }
  std::error_code ignored;
  for (const fs::path& place : places) {
    if (fs::exists(place / "gt.log", ignored)) return place;
  }
  throw std::runtime_error(fmt::format("{}: is missing", (places.front() / "gt.log").string()));
}

/// Blocks of a line "i j count" and `rows` lines.
template <typename Take>
void for_each_block(const TextRows& file, std::size_t rows, const Take& take) {
  for (std::size_t k = 0; k < file.rows().size(); k += 1 + rows) {
    const TextRow& head = file.rows()[k];
    file.require_words(head, 3);
    const Numbers numbers(file.whole_number(head, 0), file.whole_number(head, 1));
    if (k + rows >= file.rows().size()) file.fail(head, fmt::format("expected {} lines after this one", rows));
    take(numbers, k + 1, head);
  }
}

std::map<Numbers, std::array<double, 36>> read_information(const fs::path& path) {
  require_file(path);
  const TextRows file(path);
  std::map<Numbers, std::array<double, 36>> found;
  for_each_block(file, 6, [&](Numbers numbers, std::size_t first, const TextRow& head) {
    std::array<double, 36> matrix{};
    for (std::size_t r = 0; r < 6; ++r) {
      file.require_words(file.rows()[first + r], 6);
      for (std::size_t c = 0; c < 6; ++c) matrix[6 * r + c] = file.number(file.rows()[first + r], c);
    }
    if (!(matrix[0] > 0.0)) file.fail(head, "expected a number of points above 0 as the matrix's first entry");
    found[numbers] = matrix;
  });
  return found;
}

std::map<Numbers, double> read_overlaps(const fs::path& path) {
  require_file(path);
  const TextRows file(path, ",");
  std::map<Numbers, double> found;
  for (const TextRow& row : file.rows()) {
    file.require_words(row, 3);
    found[{file.whole_number(row, 0), file.whole_number(row, 1)}] = file.number(row, 2);
  }
  return found;
}

ScanGroup read_scene(const fs::path& scene, const LayoutOptions& options, bool with_information) {
  const std::string name = name_of(scene);
  const fs::path truth = ground_truth_folder(scene, options);
  ScanGroup group{
      .name = name, .dataset = "3DMatch", .sequence = name, .provenance = "fragments of 3DMatch's form", .pairs = {}};
  std::map<Numbers, std::array<double, 36>> information;
  if (with_information) information = read_information(truth / "gt.info");
  std::map<Numbers, double> overlaps;
  const fs::path overlap_file = truth / "gt_overlap.log";
  if (options.overlap) {
    overlaps = read_overlaps(overlap_file);
    group.provenance += fmt::format(", overlap {:g} to {:g}", (*options.overlap)[0], (*options.overlap)[1]);
  }
  if (options.skip_consecutive) group.provenance += ", without consecutive ones";
  const TextRows file(truth / "gt.log");
  for_each_block(file, 4, [&](Numbers numbers, std::size_t first, const TextRow& head) {
    const auto [target, source] = numbers;
    ScanPair pair{.name = fmt::format("{}-{}", source, target), .source = {}, .target = {}, .limits = kCustomaryLimits};
    pair.T_target_source = file.pose_of_rows(first, 4);
    if (target == source) file.fail(head, "source and target are one fragment");
    if (options.skip_consecutive && source == target + 1) return;
    if (options.overlap) {
      const auto overlap = overlaps.find(numbers);
      if (overlap == overlaps.end()) {
        throw std::runtime_error(
            fmt::format("{}: has no overlap of fragments {} and {}", overlap_file.string(), target, source));
      }
      const bool is_within = overlap->second > (*options.overlap)[0] && overlap->second <= (*options.overlap)[1];
      if (!is_within) return;
    }
    if (with_information) {
      const auto matrix = information.find(numbers);
      if (matrix == information.end()) {
        throw std::runtime_error(
            fmt::format("{}: has no matrix of fragments {} and {}", (truth / "gt.info").string(), target, source));
      }
      pair.information = matrix->second;
    }
    pair.source = fragment_file(scene, source);
    pair.target = fragment_file(scene, target);
    group.pairs.push_back(std::move(pair));
  });
  return group;
}

}  // namespace

ScanList read_3dmatch(const LayoutOptions& options, bool with_information) {
  ScanList list;
  const fs::path root = options.folder;
  std::vector<fs::path> scenes = folders_in(root);
  if (is_scene(root)) scenes = {root};
  for (const fs::path& scene : scenes) {
    if (!wanted(options, name_of(scene)) || !is_scene(scene)) continue;
    ScanGroup group = read_scene(scene, options, with_information);
    // Of some scenes no pair overlaps as asked for.
    if (group.pairs.empty() && options.overlap) {
      list.notes.push_back(fmt::format("{} has no pair of that overlap", group.name));
      if (options.sequences.empty()) continue;
    }
    list.groups.push_back(std::move(group));
  }
  if (list.groups.empty() && options.sequences.empty()) {
    throw std::runtime_error(
        list.notes.empty() ? fmt::format("{}: holds no scene, a folder with fragments cloud_bin_N.EXT", root.string())
                           : fmt::format("{}: no pair has that overlap", root.string()));
  }
  return list;
}

}  // namespace consimd::studies::detail
