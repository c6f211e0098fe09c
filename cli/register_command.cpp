#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
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
#include "register_options.hpp"
#include "register_report.hpp"
#include "solver_arguments.hpp"
#include "standard_streams.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

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

/// To a file, or the standard output.
void write(const std::string& file, const std::string& text) {
  if (file == "-") {
    fmt::print("{}", text);
  } else {
    studies::replace_file(file, text);
  }
}

/// What there is of a pose.
void save(const RegisterOptions& options, const RegisterReport& report, const CloudPair& clouds) {
  const Registration& run = report.runs.front();
  if (!run.has_pose()) {
    // The report would have said so.
    if (options.save_pose == "-" || options.save_inliers == "-") tell("consimd: no pose: {}\n", to_string(run.status));
    return;
  }
  if (!options.clouds.save_aligned.empty()) {
    studies::replace_file(options.clouds.save_aligned, features::moved_ply(clouds.source, run.T_target_source));
  }
  if (!options.save_pose.empty()) {
    write(options.save_pose, synth::pose_text(run.T_target_source, report.estimate_scale ? run.scale : 1.0));
  }
  if (!options.save_inliers.empty()) write(options.save_inliers, inlier_text(run));
}

/// Of two clouds the points that --pairs says are matched.
features::MatchedPoints read_pairs(const RegisterOptions& options) {
  if (options.file == "-" || options.target == "-" || options.pairs == "-") {
    throw std::invalid_argument("--pairs: reads files, not the standard input");
  }
  const std::optional<features::PairColumns> columns = pair_columns_of(options.clouds);
  if (options.pairs == "rows") return features::read_matched_rows(options.file, options.target, columns);
  return features::read_indexed_matches(options.file, options.target, options.pairs, columns);
}

Correspondences read_rows(const RegisterOptions& options) {
  const std::string& file = options.file;
  const std::string ending = std::filesystem::path(file).extension().string();
  if (!options.pairs.empty() || ending == ".npz" || ending == ".npy") {
    if (options.pairs.empty() && options.clouds.columns) {
      throw std::invalid_argument("--columns: chooses among the columns of text alone");
    }
    const features::MatchedPoints matches =
        options.pairs.empty() ? features::read_array_matches(file) : read_pairs(options);
    if (matches.source.size() >= 3) return matches.correspondences();
    throw std::runtime_error(fmt::format("{}: expected at least 3 correspondences, got {}: a pose needs three", file,
                                         matches.source.size()));
  }
  try {
    return synth::read_correspondences(file, row_columns_of(options.clouds));
  } catch (const std::runtime_error&) {
    constexpr std::array kCloudEndings{".ply", ".pcd", ".bin", ".las"};
    if (std::find(kCloudEndings.begin(), kCloudEndings.end(), ending) == kCloudEndings.end() ||
        !std::filesystem::exists(file)) {
      throw;
    }
    throw std::runtime_error(file + ": not a file of correspondences; a cloud needs the TARGET it is registered to");
  }
}

/// What is looked at, if it is asked for.
void draw(const RegisterOptions& options, const RegisterReport& report, const Correspondences& correspondences,
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

StopCondition stop_of(const RegisterOptions& options) {
  return options.time_limit ? stop_after(*options.time_limit) : StopCondition{};
}

/// One registration of the clouds after another. Returns the first one's correspondences.
Correspondences register_pairs(const RegisterOptions& options, const SolverChoice& choice, CloudPair& clouds,
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
void register_rows(const RegisterOptions& options, const SolverChoice& choice, const Correspondences& correspondences,
                   RegisterReport& report) {
  if (options.assume_inliers) {
    AssumedInliers found = register_assumed_inliers(correspondences);
    report.notes = advice(found);
    report.runs.push_back(std::move(found.registration));
    report.residuals = std::move(found.residuals);
    report.sigma = found.sigma;
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

int run_register(const RegisterOptions& options) {
  check(options);
  const SolverChoice choice = choice_of(options.solver, options.settings);
  RegisterReport report{.file = options.file,
                        .isa = std::string(to_string(active_isa())),
                        .threads = options.threads,
                        .solver = options.assume_inliers ? "least_squares" : choice.name(),
                        .options = choice.given(),
                        .filter = filter_by_name(options.filter),
                        .estimate_scale = options.estimate_scale || choice.estimates_scale(),
                        .noise_bound = options.noise_bound,
                        .assumed_inliers = options.assume_inliers};
  if (!options.matches_clouds()) report.row_viewpoint = row_viewpoint_of(options.clouds);
  std::optional<synth::ScaledPose> truth;
  if (!options.truth.empty()) {
    truth = report.estimate_scale ? synth::read_scaled_pose(options.truth)
                                  : synth::ScaledPose{synth::read_pose(options.truth)};
  }
  CloudPair clouds;
  Correspondences correspondences =
      options.matches_clouds() ? register_pairs(options, choice, clouds, report) : read_rows(options);
  if (report.row_viewpoint) correspondences.set_source_viewpoint(*report.row_viewpoint);
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

  if (options.prints_report()) fmt::print("{}", to_text(report));
  if (!options.json.empty()) write(options.json, to_json(report));
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
  auto options = std::make_shared<RegisterOptions>();
  add_register_options(*command, *options);
  command->footer(
      "Exit code: 0 when every run found a pose, 1 when one did not or left two to choose from, 2 on bad usage or "
      "input.\n"
      "Examples:\n"
      "  consimd register pair.txt                                           # finds out how noisy it is\n"
      "  consimd register source.pcd target.pcd --voxel 0.3                  # two scans\n"
      "  consimd register a.txt b.txt --pairs rows --noise-bound 0.6         # two files of N x 3, row by row\n"
      "  consimd register a.bin b.bin --refine plane --save-aligned a_in_b.ply\n"
      "  consimd register source.pcd target.pcd --view view.html             # and a page to look at them\n"
      "  consimd register pair.txt --noise-bound 0.6                         # metres, lidar clouds of 0.3 m voxels\n"
      "  consimd register pair.txt --noise-bound 0.6 --repeat 50 --truth pose.txt\n"
      "  consimd register pair.txt --noise-bound 0.6 --json -                # to the next program\n"
      "  consimd register targets.txt --assume-inliers --save-pose pose.txt  # a few targets, all of them right\n"
      "  consimd register pair.txt --noise-bound 0.6 --solver ransac --option max_iterations=10000\n"
      "  consimd register pair.txt --noise-bound 0.6 --solver pcr99 --estimate-scale   # clouds in different units");
  command->callback([&run, options] { run = [options] { return run_register(*options); }; });
}

}  // namespace consimd::cli
