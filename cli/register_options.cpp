#include "register_options.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/features/refinement.hpp>
#include <consimd/studies/replace_file.hpp>
#include "filter_option.hpp"
#include "option_checks.hpp"
#include "solver_arguments.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

/// Before clouds are read, which takes its time.
void check_viewpoints_and_clouds(const RegisterOptions& options) {
  if (options.matches_clouds()) {
    static_cast<void>(matching_options(options.clouds, options.seed));
    return;
  }
  if (const std::vector<std::string> given = options.clouds.given(); !given.empty()) {
    throw std::invalid_argument(fmt::format(
        "{} {} of two clouds, SOURCE and TARGET, that are matched here; {}", fmt::join(given, ", "),
        given.size() == 1 ? "is" : "are",
        options.pairs.empty() ? "FILE alone holds correspondences" : "--pairs tells which points are matched"));
  }
  static_cast<void>(row_viewpoint_of(options.clouds));
}

/// A file that the command writes.
struct Output {
  const char* option;
  const std::string& file;
  bool of_one_run = true;
  bool takes_standard_output = false;
};

void check_outputs(const RegisterOptions& options) {
  const Output outputs[] = {
      {.option = "--json", .file = options.json, .of_one_run = false, .takes_standard_output = true},
      {.option = "--save-correspondences", .file = options.clouds.save_correspondences, .of_one_run = false},
      {.option = "--save-pose", .file = options.save_pose, .takes_standard_output = true},
      {.option = "--save-inliers", .file = options.save_inliers, .takes_standard_output = true},
      {.option = "--save-aligned", .file = options.clouds.save_aligned},
      {.option = "--view", .file = options.view},
      {.option = "--picture", .file = options.picture}};
  const std::pair<const char*, std::filesystem::path> inputs[] = {
      {"FILE", options.file}, {"TARGET", options.target}, {"--pairs", options.pairs}, {"--truth", options.truth}};
  std::map<std::filesystem::path, const char*> written;
  for (const Output& output : outputs) {
    if (output.file.empty()) continue;
    if (output.of_one_run && options.repeat != 1) {
      throw std::invalid_argument(fmt::format("{}: writes one run, not --repeat of them", output.option));
    }
    const bool is_stream = output.file == "-";
    if (is_stream && !output.takes_standard_output) {
      throw std::invalid_argument(
          fmt::format("{}: expected a file; only --json, --save-pose and --save-inliers take '-'", output.option));
    }
    const std::filesystem::path place =
        is_stream ? std::filesystem::path(output.file) : std::filesystem::absolute(output.file).lexically_normal();
    for (const auto& [name, file] : inputs) {
      // By any name; devices lose nothing.
      std::error_code none;
      if (is_stream || !std::filesystem::is_regular_file(file, none)) continue;
      if (!std::filesystem::equivalent(file, output.file, none)) continue;
      throw std::invalid_argument(
          fmt::format("{}: '{}' is what {} reads, and would be lost", output.option, output.file, name));
    }
    if (const auto [other, is_new] = written.emplace(place, output.option); !is_new) {
      throw std::invalid_argument(
          fmt::format("{}: '{}' is written twice, by {} too", output.option, output.file, other->second));
    }
    if (!is_stream) studies::require_replaceable(output.file);
  }
}

}  // namespace

void check(const RegisterOptions& options) {
  if (options.noise_bound && !(std::isfinite(*options.noise_bound) && *options.noise_bound > 0.0)) {
    throw std::invalid_argument(
        fmt::format("--noise-bound: expected a finite length > 0, got {}", *options.noise_bound));
  }
  if (options.time_limit && !(*options.time_limit > 0.0)) {
    throw std::invalid_argument(
        fmt::format("--time-limit: expected a number of seconds > 0, got {}", *options.time_limit));
  }
  if (options.target.empty() && !options.pairs.empty()) {
    throw std::invalid_argument("--pairs: needs two clouds, SOURCE and TARGET");
  }
  if (options.target.empty()) {
    static_cast<void>(row_columns_of(options.clouds));
  } else {
    static_cast<void>(pair_columns_of(options.clouds));
  }
  check_viewpoints_and_clouds(options);
  if (options.matches_clouds() && options.estimate_scale) {
    throw std::invalid_argument("--estimate-scale: the descriptors of clouds need one unit in both");
  }
  if (options.matches_clouds() && options.assume_inliers) {
    throw std::invalid_argument("--assume-inliers: matches of clouds are never all right");
  }
  if (options.clouds.refine) static_cast<void>(features::parse_refinement_method(*options.clouds.refine));
  static_cast<void>(filter_by_name(options.filter));
  check_outputs(options);
  if (const std::string ending = std::filesystem::path(options.picture).extension();
      !options.picture.empty() && ending != ".svg" && ending != ".png") {
    throw std::invalid_argument(
        fmt::format("--picture: draws SVG or PNG, so expected a FILE.svg or FILE.png, got '{}'", options.picture));
  }
  if (const std::string ending = std::filesystem::path(options.view).extension();
      !options.view.empty() && ending != ".html" && ending != ".htm") {
    throw std::invalid_argument(
        fmt::format("--view: writes a page, so expected a FILE.html, got '{}'; --picture draws", options.view));
  }
  if (options.assume_inliers && (options.noise_bound || options.estimate_scale || options.repeat != 1)) {
    throw std::invalid_argument(
        "--assume-inliers: searches nothing, so it takes no --noise-bound, --estimate-scale or --repeat");
  }
}

void add_register_options(CLI::App& command, RegisterOptions& options) {
  command
      .add_option(
          "FILE", options.file,
          "Text, a correspondence a line: source x y z, target x y z, separated by blanks, commas or "
          "semicolons; '#' starts a comment. Or .npy of N x 6, or .npz with src_corr_points and ref_corr_points. "
          "'-' is the standard input. With TARGET: a cloud")
      ->required();
  command.add_option("TARGET", options.target,
                     fmt::format("Cloud that the first one is matched with and registered to: {}", kCloudForms));
  command.add_option("--pairs", options.pairs,
                     "Of clouds whose points are matched already: rows, each with the same row of the other, or a "
                     "file with a line for "
                     "each match: a row of FILE and one of TARGET, counted from 0");
  add_columns_option(
      command, options.clouds,
      "Of text with other columns: which are source x y z and target x y z, counted from 1, as in "
      "2,3,4,5,6,7; of two clouds, both text, also x y z of both, as in 2,3,4. Not needed where a first line or a "
      "comment names them (x1, source_x, sx), or rows are numbered before them");
  add_cloud_options(command, options.clouds);
  command.add_option("--save-correspondences", options.clouds.save_correspondences,
                     "Of clouds: write their matches to this file");
  add_refinement_options(command, options.clouds);
  command.add_flag(
      "--no-verification", options.clouds.no_verification,
      "Of clouds: let the correspondences decide alone. Otherwise a pose must be borne out by the clouds' "
      "surfaces and by what each scan saw through, is ambiguous where they agree at another pose as well, and "
      "where none stands the front end is tried up to three times more, with coarser voxels");
  command.add_option(
      "--noise-bound", options.noise_bound,
      "Largest distance of a true correspondence's target from the moved source, in the file's unit; about 3 "
      "times the noise's standard deviation. When not given it is estimated from the correspondences, which takes "
      "longer than the registration itself, or, of clouds, three times their resolution");
  command.add_option("--solver", options.solver, "Solver: " + solver_help())->capture_default_str();
  add_option_setting(command, options.settings);
  add_filter_option(command, options.filter);
  command.add_flag("--estimate-scale", options.estimate_scale,
                   "Find the scale of the source as well: x_target = R (scale * x_source) + t. Needs --noise-bound, in "
                   "the target's unit, and a solver that can (" +
                       scale_solvers() + ")");
  command.add_flag("--assume-inliers", options.assume_inliers,
                   "Take every row as right, three or more: the least-squares pose with the residual of each row, for "
                   "targets that somebody has checked. Nothing is searched or tested");
  command.add_option("--seed", options.seed, "Seed of the first run; of clouds, also of the points drawn")
      ->check(whole_number())
      ->capture_default_str();
  command
      .add_option("--repeat", options.repeat,
                  "Runs, with seeds seed, seed + 1, ...; of clouds, each draws its own points")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  add_threads_option(command, options.threads);
  command.add_option("--time-limit", options.time_limit,
                     "Seconds after which the search of a run ends: the best pose until then is judged and given, as "
                     "budget_exhausted. Results then depend on the machine. By default no search is ended");
  command.add_option(
      "--truth", options.truth,
      "File with the true pose, source to target: 4 x 4 or 3 x 4, in one line or not, below a line of 3DMatch's "
      "gt.log or not, or as TUM's tx ty tz qx qy qz qw. Reports errors against it. With "
      "--estimate-scale its rotation may be multiplied by the scale");
  command.add_option("--json", options.json, "Write the result as JSON to this file, or to the standard output ('-')");
  command.add_option(
      "--save-pose", options.save_pose,
      "Write the pose, if there is one, to this file, or to the standard output alone ('-'), as --truth reads "
      "it: 4 x 4, with --estimate-scale its rotation multiplied by the scale");
  command.add_option("--save-inliers", options.save_inliers,
                     "Write the inliers, if there is a pose, to this file, or to the standard output alone ('-'): a "
                     "row of FILE, or of clouds' --save-correspondences, "
                     "a line, counted from 0 without comments");
  command.add_option(
      "--view", options.view,
      "Write a page, FILE.html, to look at the result in a browser, with WebGL and without network: clouds before and "
      "after the pose, inliers and outliers. It needs no pose");
  command.add_option("--picture", options.picture,
                     "Write the same as a drawing, FILE.svg, or FILE.png, which Python's matplotlib draws");
}

}  // namespace consimd::cli
