#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include "commands.hpp"
#include "filter_option.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "progress.hpp"
#include "study/cell_summary.hpp"
#include "study/figures.hpp"
#include "study/limits.hpp"
#include "study/study_folder.hpp"
#include "study/sweep.hpp"
#include "study/value_list.hpp"
#include "sweep_table.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  study::SweepOptions study;
  std::string outliers{study::kPaperOutlierRatios};
  std::string sigma{study::kPaperSigmas};
  std::string filter = "none";
  int threads = 1;
  std::string out = "consimd-sweep";
  bool fresh = false;
  bool map = false;
};

std::vector<double> values_of(std::string_view option, const std::string& text) {
  try {
    return study::parse_value_list(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

std::filesystem::path program() {
  std::error_code unknown;
  return std::filesystem::read_symlink("/proc/self/exe", unknown);
}

void draw(const std::string& folder, bool map) {
  try {
    study::draw_figures(folder, program());
    fmt::print("figures: {0}/recall.svg, {0}/errors.svg{1} (and .png)\n", folder,
               map ? fmt::format(", {}/map.svg", folder) : "");
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "consimd: figures not drawn: {}\n", error.what());
  }
}

/// Measures the noise levels that the folder lacks; each is written as it ends. Whether none is left.
bool measure_limits(const study::SweepOptions& options, study::StudyFolder& folder) {
  const std::size_t done = folder.limits().size();
  if (done == options.sigmas.size()) return true;
  const InterruptionGuard guard;
  Progress progress(options.sigmas.size() * study::kLimitProblems, done * study::kLimitProblems, "limit problems");
  const study::LimitControl control{.on_problem = [&] { progress.step(); },
                                    .stop_requested = [] { return InterruptionGuard::requested(); }};
  for (const double sigma : options.sigmas) {
    if (std::ranges::count(folder.limits(), sigma, &study::LimitRecord::sigma) != 0) continue;
    const std::optional<study::LimitRecord> limit = study::measure_limit(options, sigma, control);
    if (!limit) return false;
    folder.append(*limit);
  }
  return true;
}

int run_sweep_command(Options options) {
  options.study.outlier_ratios = values_of("--outliers", options.outliers);
  options.study.sigmas = values_of("--sigma", options.sigma);
  options.study.filter = filter_by_name(options.filter);
  study::TrialTable table(std::move(options.study));
  const study::RunFacts facts{.isa = to_string(active_isa()), .threads = options.threads};
  study::StudyFolder folder(options.out, table, facts, options.fresh);

  fmt::print("{} trials in {} cells, noise bound 3 sigma, {} on {} thread{}, {} done before, writing to {}\n",
             table.size(), table.options().cells(), facts.isa, facts.threads, facts.threads == 1 ? "" : "s",
             table.filled(), options.out);
  std::fflush(stdout);
  if (!table.complete()) {
    const InterruptionGuard guard;
    Progress progress(table.size(), table.filled(), "trials");
    const study::SweepControl control{.on_trial =
                                          [&](const study::TrialRecord& record) {
                                            folder.append(record);
                                            progress.step();
                                          },
                                      .stop_requested = [] { return InterruptionGuard::requested(); }};
    with_threads(options.threads, [&] { study::run_sweep(table, control); });
  }
  if (!table.complete()) {
    fmt::print(stderr, "consimd: stopped after {} of {} trials; the same command resumes\n", table.filled(),
               table.size());
    return kInterrupted;
  }
  folder.finish(table, facts);
  fmt::print("\n{}\n", sweep_table(study::summarise_ratios(table)));
  fmt::print("Errors are means over all trials, failures included; the oracle is least squares on the true inliers.\n");
  std::fflush(stdout);
  if (options.map) {
    if (!with_threads(options.threads, [&] { return measure_limits(table.options(), folder); })) {
      fmt::print(stderr, "consimd: stopped after the limits of {} of {} noise levels; the same command resumes\n",
                 folder.limits().size(), table.options().sigmas.size());
      return kInterrupted;
    }
    fmt::print("\n{}\n", limit_table(folder.limits(), table.options().points));
  }
  fmt::print("data: {0}/trials.csv, {0}/cells.csv, {0}/summary.json{1}\n", options.out,
             options.map ? fmt::format(", {}/limits.csv", options.out) : "");
  std::fflush(stdout);
  draw(options.out, options.map);
  return kSuccess;
}

}  // namespace

void add_sweep_command(CLI::App& app, Action& run) {
  CLI::App* command =
      app.add_subcommand("sweep", "Run the noise study: recall and errors over noise and outlier ratio");
  auto options = std::make_shared<Options>();
  study::SweepOptions& study = options->study;
  command->add_option("--points", study.points, "Correspondences of a problem")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--outliers", options->outliers, "Outlier ratios in [0, 1): a list, or start:end:count")
      ->capture_default_str();
  command
      ->add_option("--sigma", options->sigma,
                   "Standard deviations of the inliers' noise, metres: a list, or start:end:count evenly spaced values")
      ->capture_default_str();
  command->add_option("--trials", study.trials, "Problems per outlier ratio and noise level")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--solver", study.solvers, "Solvers, separated by commas; 'consimd info' lists them")
      ->delimiter(',')
      ->capture_default_str();
  add_filter_option(*command, options->filter);
  command->add_option("--seed", study.seed, "Seed of the data; trial k runs its solver with seed + k")
      ->check(whole_number())
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--out", options->out, "Folder for the results, made if missing")->capture_default_str();
  command->add_flag("--fresh", options->fresh, "Start over: drop the study that the folder holds");
  command->add_flag("--map", options->map,
                    "Also measure where the limit lies (limits.csv) and draw maps over outlier ratio and noise");
  command->footer(
      "Every problem has points in a cube of 200 m under one random rigid motion. A solver gets the noise bound 3 "
      "sigma;\n"
      "it succeeds when the RMSE of the true inliers is below 3 sigma. Ctrl-C keeps what is done; the same command "
      "resumes.\n"
      "Writes trials.csv, cells.csv, summary.json, and recall and errors as .svg and .png. CONSIMD_PYTHON names the "
      "Python\n"
      "that draws (it needs matplotlib), CONSIMD_PLOT_SCRIPT another script.\n"
      "--map adds limits.csv and map.svg (and .png). Per noise level it runs the solver on 10 problems without a true\n"
      "pose: the limit is the outlier ratio at which the true pose has no more support than the best pose of these.\n"
      "Exit code: 0 when complete, 2 on bad usage, 130 when stopped.\n"
      "Examples:\n"
      "  consimd sweep                                                the paper's study: 25000 trials\n"
      "  consimd sweep --outliers 0.9,0.99 --sigma 0.5,1,2 --trials 20 --out quick\n"
      "  consimd sweep --map --outliers 0.5,0.9,0.95,0.98,0.99,0.995 --sigma 0.1,0.5,1,2,5 --trials 20 --out map");
  command->callback([&run, options] { run = [options] { return run_sweep_command(*options); }; });
}

}  // namespace consimd::cli
