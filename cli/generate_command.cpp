#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <consimd/synth/noise_study.hpp>
#include <consimd/synth/problem_files.hpp>

#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/sweep_options.hpp>
#include "commands.hpp"
#include "option_checks.hpp"

namespace consimd::cli {
namespace {

struct Options {
  std::size_t points = 3000;
  double outliers = 0.9;
  double sigma = 1.0;
  double scale = 1.0;
  std::uint64_t seed = 1;
  std::uint32_t trial = 0;
  std::string out;
};

/// What `problem` is and when it counts as solved. The limits are the pose errors that alone would bring the true
/// inliers' RMSE to the study's 3 sigma: 3 sigma^2 of it are noise, so sqrt(6) sigma remain for a shift or a turn.
std::string case_json(const synth::Problem& problem) {
  const double bound = synth::noise_study_bound(problem.sigma);
  const double shift = std::sqrt(6.0) * problem.sigma;
  const double lever =
      synth::NoiseStudyOptions{}.half_extent * std::sqrt(2.0 / 3.0);  // RMS distance of a cube's points from an axis
  std::size_t within = 0;
  for (std::size_t i = 0; i < problem.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> source(problem.source.data() + 3 * i);
    const Eigen::Map<const Eigen::Vector3d> target(problem.target.data() + 3 * i);
    within += (problem.T_target_source * (problem.scale * source) - target).norm() < bound;
  }
  nlohmann::ordered_json json{{"dataset", "consimd noise study"},
                              {"correspondences", problem.size()},
                              {"noise_bound", bound},
                              {"inliers_within_noise_bound", within},
                              {"max_rotation_error_deg", shift / lever * 180.0 / std::numbers::pi},
                              {"max_translation_error_m", shift}};
  if (problem.scale != 1.0) json["scale"] = problem.scale;
  return json.dump(1) + "\n";
}

int run_generate(const Options& options) {
  studies::SweepOptions checked;
  checked.points = options.points;
  checked.outlier_ratios = {options.outliers};
  checked.sigmas = {options.sigma};
  studies::validate(checked);
  if (!(options.scale > 0.0 && std::isfinite(options.scale))) {
    throw std::invalid_argument(fmt::format("--scale: expected a finite number > 0, got {}", options.scale));
  }
  studies::require_writable_folder(options.out);

  const synth::Problem problem = synth::noise_study_problem({.correspondences = options.points,
                                                             .outlier_ratio = options.outliers,
                                                             .sigma = options.sigma,
                                                             .seed = options.seed,
                                                             .trial = options.trial,
                                                             .scale = options.scale});
  synth::write_problem(problem, options.out);
  studies::replace_file(std::filesystem::path(options.out) / "case.json", case_json(problem));
  fmt::print("{}: {} correspondences, noise bound {} m (3 sigma)\n", options.out, problem.size(),
             synth::noise_study_bound(options.sigma));
  return kSuccess;
}

}  // namespace

void add_generate_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand("generate", "Write a problem of the noise study, with its ground truth");
  auto options = std::make_shared<Options>();
  command->add_option("--points", options->points, "Correspondences")->check(whole_number())->capture_default_str();
  command->add_option("--outliers", options->outliers, "Share of wrong correspondences, in [0, 1)")
      ->capture_default_str();
  command->add_option("--sigma", options->sigma, "Standard deviation of the inliers' noise, metres an axis")
      ->capture_default_str();
  command
      ->add_option("--scale", options->scale,
                   "Scale of the source: its points are divided by it, and pose.txt holds the rotation multiplied by "
                   "it. Found by 'consimd register --estimate-scale'")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of the study")->check(whole_number())->capture_default_str();
  command->add_option("--trial", options->trial, "Trial of the study, from 0")
      ->check(whole_number(0, 999'999))
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder to write to, made if missing")->required();
  command->footer(
      "Writes correspondences.txt (N x 6, metres), pose.txt (4 x 4, source to target), labels.txt (1: inlier) and\n"
      "case.json (noise bound, limits of success). The data are those that 'consimd sweep' gives its solvers in that\n"
      "trial at that outlier ratio and noise; a solver's seed there is seed + trial.\n"
      "Example:\n"
      "  consimd generate --outliers 0.98 --sigma 2.5 --seed 1 --trial 7 --out problem\n"
      "  consimd register problem/correspondences.txt --noise-bound 7.5 --seed 8 --truth problem/pose.txt");
  command->callback([&run, options] { run = [options] { return run_generate(*options); }; });
}

}  // namespace consimd::cli
