#include "scan_arguments.hpp"

#include <array>
#include <stdexcept>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "option_checks.hpp"
#include "text/words.hpp"

namespace consimd::cli {
namespace {

// All but --scans itself.
constexpr const char* kOptions[] = {"--layout",      "--sequences",        "--pairs",           "--distance",
                                    "--pair-list",   "--ground-truth",     "--overlap",         "--skip-consecutive",
                                    "--voxel",       "--keypoints",        "--matches",         "--missing",
                                    "--noise-bound", "--source-viewpoint", "--target-viewpoint"};

std::array<double, 2> overlap_of(std::string_view text) {
  std::array<double, 2> shares{};
  const std::size_t colon = text.find(':');
  const std::string_view words[] = {text.substr(0, colon),
                                    colon == std::string_view::npos ? "" : text.substr(colon + 1)};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto share = text::number_in<double>(words[k]);
    if (!share) throw std::invalid_argument(fmt::format("--overlap: expected LEAST:MOST, as 0.1:0.3, got '{}'", text));
    shares[k] = *share;
  }
  return shares;
}

}  // namespace

void add_scan_options(CLI::App& command, ScanArguments& arguments) {
  studies::LayoutOptions& layout = arguments.layout;
  command.add_option("--scans", layout.folder,
                     "Folder of a data set of scans with poses; of the layout pairs also the CSV file");
  command.add_option("--layout", layout.layout, "Of scans: how the data set lies in its folder; listed below");
  command
      .add_option("--sequences", layout.sequences,
                  "Of scans: sequences (kitti), scenes (eth, 3dmatch) or groups (pairs), separated by commas; all when "
                  "not given")
      ->delimiter(',');
  command
      .add_option(
          "--pairs", layout.pairs,
          "Of scans: most pairs of each sequence, drawn by the seed. When not given 200 of kitti, all of others")
      ->check(whole_number(1, 1'000'000));
  command.add_option("--distance", layout.distance, "Of kitti: metres between the scans of a pair, within a tenth")
      ->capture_default_str();
  command.add_option(
      "--pair-list", layout.pair_list,
      "Of kitti: file with a pair a line, SEQUENCE SOURCE TARGET, frames by number, instead of drawn ones");
  command.add_option("--ground-truth", layout.ground_truth,
                     "Of 3dmatch: folder with SCENE/gt.log, where these are not with the fragments");
  command.add_option("--overlap", arguments.overlap,
                     "Of 3dmatch: LEAST:MOST, only pairs with such an overlap in gt_overlap.log; 0.1:0.3 is 3DLoMatch");
  command.add_flag("--skip-consecutive", layout.skip_consecutive,
                   "Of 3dmatch: leave out fragments that follow one another, as 3DMatch's own recall does");
  add_cloud_options(command, arguments.clouds);
  command.add_option(
      "--noise-bound", arguments.noise_bound,
      "Of scans: noise bound of all pairs, in their unit; three times a pair's resolution when not given");
  // Each layout has defaults of its own.
  const auto describe = [&](const char* option, const char* description) {
    command.get_option(option)->default_str("")->description(description);
  };
  describe("--voxel", "Of scans: side of the voxels that they are thinned out with; the layout's when not given");
  describe("--keypoints",
           "Of scans: the points that are matched: random:COUNT, farthest:COUNT, iss, iss:COUNT or all, as of consimd "
           "register; the layout's when not given");
  describe("--matches", "Of scans: mutual:K or nearest:K, as of consimd register; mutual:3 when not given");
  describe("--missing", "Of scans: a point whose three coordinates are this number is none");
  describe("--source-viewpoint",
           "Of scans: where each pair's source was scanned from, X,Y,Z in its own frame, or none; its origin when not "
           "given");
  describe("--target-viewpoint", "Of scans: the same of the target");
}

std::optional<studies::ScanOptions> scans_of(const CLI::App& command, const ScanArguments& arguments,
                                             const std::string& cache) {
  if (arguments.layout.folder.empty()) {
    for (const char* option : kOptions) {
      if (command.get_option(option)->count() != 0) {
        throw std::invalid_argument(fmt::format("{}: it is for --scans, which is not given", option));
      }
    }
    return std::nullopt;
  }
  studies::ScanOptions options{.layout = arguments.layout,
                               .front_end = studies::layout_front_end(arguments.layout.layout),
                               .missing = arguments.clouds.missing,
                               .noise_bound = arguments.noise_bound,
                               .cache = cache};
  if (!arguments.overlap.empty()) options.layout.overlap = overlap_of(arguments.overlap);
  const features::CloudMatchingOptions given = matching_options(arguments.clouds, options.layout.seed);
  if (given.voxel) options.front_end.voxel = given.voxel;
  if (command.get_option("--keypoints")->count() != 0) {
    options.front_end.keypoints = given.keypoints;
    options.front_end.farthest = given.farthest;
    options.front_end.iss = given.iss;
  }
  if (command.get_option("--matches")->count() != 0) options.front_end.matches = given.matches;
  options.front_end.source_viewpoint = given.source_viewpoint;
  options.front_end.target_viewpoint = given.target_viewpoint;
  return options;
}

}  // namespace consimd::cli
