#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <consimd/features/cloud_files.hpp>
#include <consimd/features/correspondence_files.hpp>
#include <consimd/features/register_clouds.hpp>
#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/solvers/advice.hpp>
#include <consimd/solvers/assumed_inliers.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/metrics.hpp>
#include <consimd/synth/problem_files.hpp>

#include <consimd/studies/registration_picture.hpp>
#include <consimd/studies/replace_file.hpp>
#include "cloud_arguments.hpp"
#include "commands.hpp"
#include "figure_report.hpp"
#include "filter_option.hpp"
#include "option_checks.hpp"
#include "register_report.hpp"
#include "solver_arguments.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  std::string file;
  std::string target;  ///< of two clouds; empty: `file` holds correspondences
  std::string pairs;   ///< of two clouds whose points are matched already: "rows", or a file
  std::vector<std::size_t> columns;
  CloudArguments clouds;
  std::optional<double> noise_bound;
  std::string solver = solvers().front().name;
  std::vector<std::string> settings;
  std::string filter{to_string(SolverOptions().filter)};
  bool estimate_scale = false;
  std::uint64_t seed = SolverOptions().seed;
  std::uint32_t repeat = 1;
  int threads = 1;
  std::optional<double> time_limit;
  bool assume_inliers = false;
  std::string truth;
  std::string json;
  std::string save_pose;
  std::string save_inliers;
  std::string view;
  std::string picture;

  /// Whether there are two clouds to be matched.
  [[nodiscard]] bool matches_clouds() const { return !target.empty() && pairs.empty(); }
};

void check(const Options& options) {
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
  if (!options.target.empty() && !options.columns.empty()) {
    throw std::invalid_argument("--columns: is of a file of correspondences, FILE");
  }
  if (!options.columns.empty() &&
      (options.columns.size() != 6 ||
       std::find(options.columns.begin(), options.columns.end(), 0u) != options.columns.end())) {
    throw std::invalid_argument("--columns: expected six columns counted from 1, as in 2,3,4,5,6,7");
  }
  if (!options.matches_clouds() && options.clouds.given()) {
    throw std::invalid_argument(
        "--voxel, --keypoints, --matches, --missing, --target-viewpoint, --save-correspondences, --no-verification, "
        "--refine and --save-aligned are of two clouds, SOURCE and TARGET, that are matched here");
  }
  if (options.matches_clouds() && options.estimate_scale) {
    throw std::invalid_argument("--estimate-scale: the descriptors of clouds need one unit in both");
  }
  if (options.matches_clouds() && options.assume_inliers) {
    throw std::invalid_argument("--assume-inliers: matches of clouds are never all right");
  }
  if (!options.clouds.save_correspondences.empty()) studies::require_replaceable(options.clouds.save_correspondences);
  if (options.clouds.refine) static_cast<void>(features::parse_refinement_method(*options.clouds.refine));
  static_cast<void>(filter_by_name(options.filter));
  if (!options.json.empty() && options.json != "-") studies::require_replaceable(options.json);
  std::set<std::string> written{options.json, options.clouds.save_correspondences};
  for (const auto& [name, file] :
       {std::pair("--save-pose", options.save_pose), std::pair("--save-inliers", options.save_inliers),
        std::pair("--save-aligned", options.clouds.save_aligned), std::pair("--view", options.view),
        std::pair("--picture", options.picture)}) {
    if (file.empty()) continue;
    if (options.repeat != 1) throw std::invalid_argument(fmt::format("{}: writes one run, not --repeat of them", name));
    if (file == "-") throw std::invalid_argument(fmt::format("{}: expected a file; only --json takes '-'", name));
    if (!written.insert(file).second) throw std::invalid_argument(fmt::format("{}: '{}' is written twice", name, file));
    studies::require_replaceable(file);
  }
  if (const std::string ending = std::filesystem::path(options.picture).extension();
      !options.picture.empty() && ending != ".svg" && ending != ".png") {
    throw std::invalid_argument(
        fmt::format("--picture: draws SVG or PNG, so expected a FILE.svg or FILE.png, got '{}'", options.picture));
  }
  if (options.assume_inliers && (options.noise_bound || options.estimate_scale || options.repeat != 1)) {
    throw std::invalid_argument(
        "--assume-inliers: searches nothing, so it takes no --noise-bound, --estimate-scale or --repeat");
  }
}

/// Whether many more rows agree with the inverse of `truth` than with itself.
bool looks_inverted(const Correspondences& correspondences, const RigidTransform& truth, double noise_bound) {
  const std::array<WorkingPose, 2> poses{to_working_pose(to_working_frame(truth, correspondences)),
                                         to_working_pose(to_working_frame(truth.inverse(), correspondences))};
  std::array<std::uint32_t, 2> counts{};
  alignment_counts(correspondences, poses, noise_bound, counts);
  return counts[1] >= 3 && counts[1] > 2 * counts[0];
}

/// The inliers of the run as rows of the file's correspondences, from 0.
std::string inlier_text(const Registration& run) {
  std::string text = "# correspondences within the noise bound of the pose, counted from 0\n";
  for (const std::uint32_t row : run.inliers) text += fmt::format("{}\n", row);
  return text;
}

void save(const Options& options, const RegisterReport& report, const CloudPair& clouds) {
  const Registration& run = report.runs.front();
  if (!options.clouds.save_aligned.empty() && run.has_pose()) {
    studies::replace_file(options.clouds.save_aligned, features::moved_ply(clouds.source, run.T_target_source));
  }
  if (!options.save_pose.empty() && run.has_pose()) {
    synth::write_pose(run.T_target_source, report.estimate_scale ? run.scale : 1.0, options.save_pose);
  }
  if (!options.save_inliers.empty() && run.has_pose()) studies::replace_file(options.save_inliers, inlier_text(run));
}

/// Of two clouds the points that --pairs says are matched.
features::MatchedPoints read_pairs(const Options& options) {
  if (options.file == "-" || options.target == "-" || options.pairs == "-") {
    throw std::invalid_argument("--pairs: reads files, not the standard input");
  }
  if (options.pairs == "rows") return features::read_matched_rows(options.file, options.target);
  return features::read_indexed_matches(options.file, options.target, options.pairs);
}

Correspondences read_rows(const Options& options) {
  const std::string& file = options.file;
  const std::string ending = std::filesystem::path(file).extension().string();
  if (!options.pairs.empty() || ending == ".npz") {
    const features::MatchedPoints matches =
        options.pairs.empty() ? features::read_npz_matches(file) : read_pairs(options);
    if (matches.source.size() >= 3) return matches.correspondences();
    throw std::runtime_error(
        fmt::format("{}: expected at least 3 correspondences, got {}", file, matches.source.size()));
  }
  try {
    return synth::read_correspondences(file, options.columns);
  } catch (const std::runtime_error&) {
    constexpr std::array kCloudEndings{".ply", ".pcd", ".npy", ".bin", ".las"};
    if (std::find(kCloudEndings.begin(), kCloudEndings.end(), ending) == kCloudEndings.end() ||
        !std::filesystem::exists(file)) {
      throw;
    }
    throw std::runtime_error(file + ": not a file of correspondences; a cloud needs the TARGET it is registered to");
  }
}

/// What is looked at, if it is asked for.
void draw(const Options& options, const RegisterReport& report, const Correspondences& correspondences,
          const CloudPair& clouds) {
  studies::RegistrationPicture picture{.correspondences = &correspondences,
                                       .registration = &report.runs.front(),
                                       .source_name = options.file,
                                       .target_name = options.target,
                                       .solver = report.solver};
  if (report.clouds) {
    picture.source = &clouds.source;
    picture.target = &clouds.target;
  }
  if (!options.view.empty()) studies::replace_file(options.view, studies::registration_page(picture));
  if (options.picture.empty()) return;
  const std::string drawing = studies::registration_svg(picture);
  const bool png = std::filesystem::path(options.picture).extension() == ".png";
  studies::replace_file(options.picture, png ? drawn_as_png(drawing) : drawing);
}

/// Adds what there is to say of the first run, and of the first without a pose: what all lack is looked for once.
void advise(const Correspondences& correspondences, const Registration& run, RegisterReport& report) {
  const bool is_first_without = !run.has_pose() && std::ranges::all_of(report.runs, &Registration::has_pose);
  if (!report.runs.empty() && !is_first_without) return;
  for (std::string& note : advice(correspondences, run)) {
    if (std::ranges::find(report.notes, note) == report.notes.end()) report.notes.push_back(std::move(note));
  }
}

StopCondition stop_of(const Options& options) {
  return options.time_limit ? stop_after(*options.time_limit) : StopCondition{};
}

/// One registration of the clouds after another. Returns the first one's correspondences.
Correspondences register_pairs(const Options& options, const SolverChoice& choice, CloudPair& clouds,
                               RegisterReport& report) {
  clouds = read_clouds(options.file, options.target, options.clouds);
  report.file += " and " + options.target;
  report.cloud_arguments = options.clouds;
  std::optional<features::RefinementMethod> method;
  if (options.clouds.refine) method = features::parse_refinement_method(*options.clouds.refine);
  for (std::uint32_t run = 0; run < options.repeat; ++run) {
    const std::uint64_t seed = options.seed + run;
    features::CloudRegistration found = with_threads(options.threads, [&] {
      return features::register_clouds(clouds.source, clouds.target,
                                       {.matching = matching_options(options.clouds, seed),
                                        .noise_bound = options.noise_bound,
                                        .solver = choice.label(),
                                        .filter = report.filter,
                                        .seed = seed,
                                        .stop = stop_of(options),
                                        .verify = !options.clouds.no_verification,
                                        .refine = method});
    });
    advise(found.matches.correspondences, found.registration, report);
    report.runs.push_back(std::move(found.registration));
    report.attempts.push_back(found.attempts);
    if (found.verdict) report.verdicts.push_back(*found.verdict);
    if (method) report.refinements.push_back(found.refinement);
    if (!report.clouds) report.clouds = std::move(found.matches);
  }
  if (!report.noise_bound) report.noise_bound = report.clouds->noise_bound;
  if (!options.clouds.save_correspondences.empty()) {
    studies::replace_file(options.clouds.save_correspondences, correspondence_text(*report.clouds));
  }
  return std::move(report.clouds->correspondences);
}

/// Registrations of the rows of a file, in each run with another seed.
void register_rows(const Options& options, const SolverChoice& choice, const Correspondences& correspondences,
                   RegisterReport& report) {
  if (options.assume_inliers) {
    AssumedInliers found = register_assumed_inliers(correspondences);
    report.runs.push_back(std::move(found.registration));
    report.residuals = std::move(found.residuals);
    report.sigma = found.sigma;
    if (found.geometry != PointGeometry::determined) {
      report.notes.push_back(
          fmt::format("the points of a cloud are {}: they leave a rotation free", to_string(found.geometry)));
    }
    return;
  }
  for (std::uint32_t k = 0; k < options.repeat; ++k) {
    Registration run = register_by_choice(choice, correspondences,
                                          {.noise_bound = report.noise_bound,
                                           .seed = options.seed + k,
                                           .filter = report.filter,
                                           .estimate_scale = options.estimate_scale,
                                           .stop = stop_of(options)});
    advise(correspondences, run, report);
    report.runs.push_back(std::move(run));
  }
}

int run_register(const Options& options) {
  check(options);
  const SolverChoice choice = choice_of(options.solver, options.settings);
  const auto viewpoint = viewpoint_of("--source-viewpoint", options.clouds.source_viewpoint);
  if (!viewpoint && !options.matches_clouds()) {
    throw std::invalid_argument(
        "--source-viewpoint: none is of clouds; of correspondences leave it out, or give X,Y,Z");
  }
  RegisterReport report{.file = options.file,
                        .isa = std::string(to_string(active_isa())),
                        .threads = options.threads,
                        .solver = options.assume_inliers ? "least_squares" : choice.name(),
                        .options = choice.given(),
                        .filter = filter_by_name(options.filter),
                        .estimate_scale = options.estimate_scale || choice.estimates_scale(),
                        .noise_bound = options.noise_bound,
                        .assumed_inliers = options.assume_inliers};
  std::optional<synth::ScaledPose> truth;
  if (!options.truth.empty()) {
    truth = report.estimate_scale ? synth::read_scaled_pose(options.truth)
                                  : synth::ScaledPose{synth::read_pose(options.truth)};
  }
  CloudPair clouds;
  Correspondences correspondences =
      options.matches_clouds() ? register_pairs(options, choice, clouds, report) : read_rows(options);
  if (viewpoint) correspondences.set_source_viewpoint(*viewpoint);
  report.correspondences = correspondences.size();
  if (!options.matches_clouds()) {
    with_threads(options.threads, [&] { register_rows(options, choice, correspondences, report); });
  }
  if (truth) {
    for (const Registration& run : report.runs) {
      report.errors.push_back({synth::rotation_error_deg(run.T_target_source, truth->T_target_source),
                               synth::translation_error(run.T_target_source, truth->T_target_source),
                               synth::scale_error(run.scale, truth->scale)});
    }
    report.truth_inverted = !report.estimate_scale &&
                            looks_inverted(correspondences, truth->T_target_source, report.runs.front().noise_bound);
  }

  if (options.json.empty()) {
    fmt::print("{}", to_text(report));
  } else if (options.json == "-") {
    fmt::print("{}", to_json(report));
  } else {
    studies::replace_file(options.json, to_json(report));
  }
  save(options, report, clouds);
  with_threads(options.threads, [&] { draw(options, report, correspondences, clouds); });
  const bool all_found = std::all_of(report.runs.begin(), report.runs.end(), [](const Registration& run) {
    return run.has_pose() && run.status != Status::ambiguous;
  });
  return all_found ? kSuccess : kNoPose;
}

}  // namespace

void add_register_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand(
      "register", "Find the rigid motion that a file of correspondences agrees on, or that takes a cloud to another");
  auto options = std::make_shared<Options>();
  command
      ->add_option("FILE", options->file,
                   "Text, a correspondence a line: source x y z, target x y z, separated by blanks, commas or "
                   "semicolons; '#' starts a comment. Or .npz with src_corr_points and ref_corr_points. '-' is the "
                   "standard input. With TARGET: a cloud")
      ->required();
  command->add_option("TARGET", options->target,
                      fmt::format("Cloud that the first one is matched with and registered to: {}", kCloudForms));
  command->add_option("--pairs", options->pairs,
                      "Of clouds whose points are matched already: rows, each with the same row of the other, or a "
                      "file with a line for "
                      "each match: a row of FILE and one of TARGET, counted from 0");
  command
      ->add_option(
          "--columns", options->columns,
          "Of text with other columns: which are source x y z and target x y z, counted from 1, as in "
          "2,3,4,5,6,7. Not needed where a first line names them (x1, source_x, sx), or rows are numbered before "
          "them")
      ->delimiter(',');
  add_cloud_options(*command, options->clouds);
  command->add_option("--save-correspondences", options->clouds.save_correspondences,
                      "Of clouds: write their matches to this file");
  add_refinement_options(*command, options->clouds);
  command->add_flag(
      "--no-verification", options->clouds.no_verification,
      "Of clouds: let the correspondences decide alone. Otherwise a pose must be borne out by the clouds' "
      "surfaces and by what each scan saw through, and where none is sure the front end is tried once more "
      "with voxels of one and a half times the side");
  command->add_option(
      "--noise-bound", options->noise_bound,
      "Largest distance of a true correspondence's target from the moved source, in the file's unit; about 3 "
      "times the noise's standard deviation. When not given it is estimated from the correspondences, which takes two "
      "to fourteen times as long, or, of clouds, three times their resolution");
  command->add_option("--solver", options->solver, "Solver: " + solver_help())->capture_default_str();
  add_option_setting(*command, options->settings);
  add_filter_option(*command, options->filter);
  command->add_flag(
      "--estimate-scale", options->estimate_scale,
      "Find the scale of the source as well: x_target = R (scale * x_source) + t. Needs --noise-bound, in "
      "the target's unit, and a solver that can (" +
          scale_solvers() + ")");
  command->add_flag("--assume-inliers", options->assume_inliers,
                    "Take every row as right, three or more: the least-squares pose with the residual of each row, for "
                    "targets that somebody has checked. Nothing is searched or tested");
  command->add_option("--seed", options->seed, "Seed of the first run; of clouds, also of the points drawn")
      ->check(whole_number())
      ->capture_default_str();
  command
      ->add_option("--repeat", options->repeat,
                   "Runs, with seeds seed, seed + 1, ...; of clouds, each draws its own points")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--time-limit", options->time_limit,
                      "Seconds after which the search of a run ends: the best pose until then is judged and given, as "
                      "budget_exhausted. Results then depend on the machine. By default no search is ended");
  command->add_option(
      "--truth", options->truth,
      "File with the true pose, source to target: 4 x 4 or 3 x 4, in one line or not, below a line of 3DMatch's "
      "gt.log or not, or as TUM's tx ty tz qx qy qz qw. Reports errors against it. With "
      "--estimate-scale its rotation may be multiplied by the scale");
  command->add_option("--json", options->json,
                      "Write the result as JSON to this file, or to the standard output ('-')");
  command->add_option("--save-pose", options->save_pose,
                      "Write the pose, if there is one, to this file as --truth reads it: 4 x 4, with --estimate-scale "
                      "its rotation multiplied by the scale");
  command->add_option(
      "--save-inliers", options->save_inliers,
      "Write the inliers, if there is a pose, to this file: a row of FILE, or of clouds' --save-correspondences, "
      "a line, counted from 0 without comments");
  command->add_option(
      "--view", options->view,
      "Write a page to look at the result in a browser, with WebGL and without network: clouds before and "
      "after the pose, inliers and outliers. It needs no pose");
  command->add_option("--picture", options->picture,
                      "Write the same as a drawing, FILE.svg, or FILE.png, which Python's matplotlib draws");
  command->footer(
      "Exit code: 0 when every run found a pose, 1 when one did not or left two to choose from, 2 on bad usage or "
      "input.\n"
      "Examples:\n"
      "  consimd register pair.txt                                           finds out how noisy it is\n"
      "  consimd register source.pcd target.pcd --voxel 0.3                  two scans\n"
      "  consimd register a.txt b.txt --pairs rows --noise-bound 0.6         two files of N x 3, row by row\n"
      "  consimd register a.bin b.bin --refine plane --save-aligned a_in_b.ply\n"
      "  consimd register source.pcd target.pcd --view view.html             and a page to look at them\n"
      "  consimd register pair.txt --noise-bound 0.6                         metres, lidar clouds of 0.3 m voxels\n"
      "  consimd register pair.txt --noise-bound 0.6 --repeat 50 --truth pose.txt\n"
      "  consimd register pair.txt --noise-bound 0.6 --json -                to the next program\n"
      "  consimd register targets.txt --assume-inliers --save-pose pose.txt  a few targets, all of them right\n"
      "  consimd register pair.txt --noise-bound 0.6 --solver ransac --option max_iterations=10000\n"
      "  consimd register pair.txt --noise-bound 0.6 --solver pcr99 --estimate-scale   clouds in different units");
  command->callback([&run, options] { run = [options] { return run_register(*options); }; });
}

}  // namespace consimd::cli
