#include <cmath>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/synth/problem_families.hpp>
#include <consimd/synth/problem_files.hpp>

#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/sweep_options.hpp>
#include "commands.hpp"
#include "family_arguments.hpp"
#include "option_checks.hpp"

namespace consimd::cli {
namespace {

struct Options {
  std::string family = "gaussian";
  std::size_t points = 3000;
  double outliers = 0.9;
  double sigma = 1.0;
  double scale = 1.0;
  std::uint64_t seed = 1;
  std::uint32_t trial = 0;
  std::string out;
};

int run_generate(const Options& options) {
  studies::SweepOptions checked;
  checked.points = {options.points};
  checked.families = {options.family};
  checked.outlier_ratios = {options.outliers};
  checked.sigmas = {options.sigma};
  studies::validate(checked);
  if (!(options.scale > 0.0 && std::isfinite(options.scale))) {
    throw std::invalid_argument(fmt::format("--scale: expected a finite number > 0, got {}", options.scale));
  }
  const synth::Problem problem = synth::family_problem(options.family, {.correspondences = options.points,
                                                                        .outlier_ratio = options.outliers,
                                                                        .sigma = options.sigma,
                                                                        .seed = options.seed,
                                                                        .trial = options.trial,
                                                                        .scale = options.scale});
  studies::require_writable_folder(options.out);
  synth::write_problem(problem, options.out);
  fmt::print("{}: {} correspondences, noise bound {} m (3 sigma)\n", options.out, problem.size(),
             synth::noise_study_bound(options.sigma));
  return kSuccess;
}

}  // namespace

void add_generate_command(CLI::App& app, Action& run) {
  CLI::App* command = app.add_subcommand("generate", "Write a problem of the noise study, with its ground truth");
  auto options = std::make_shared<Options>();
  command->add_option("--family", options->family, "Family of the problem, see below")->capture_default_str();
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
      "Families:\n" +
      family_lines() +
      "Example:\n"
      "  consimd generate --outliers 0.98 --sigma 2.5 --seed 1 --trial 7 --out problem\n"
      "  consimd register problem/correspondences.txt --noise-bound 7.5 --seed 8 --truth problem/pose.txt");
  command->callback([&run, options] { run = [options] { return run_generate(*options); }; });
}

}  // namespace consimd::cli
