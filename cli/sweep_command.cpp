#include <filesystem>
#include <memory>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include "commands.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "progress.hpp"
#include "study/cell_summary.hpp"
#include "study/figures.hpp"
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
  int threads = 1;
  std::string out = "consimd-sweep";
  bool fresh = false;
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

void draw(const std::string& folder) {
  try {
    study::draw_figures(folder, program());
    fmt::print("figures: {0}/recall.svg, {0}/errors.svg (and .png)\n", folder);
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "consimd: figures not drawn: {}\n", error.what());
  }
}

int run_sweep_command(Options options) {
  options.study.outlier_ratios = values_of("--outliers", options.outliers);
  options.study.sigmas = values_of("--sigma", options.sigma);
  study::TrialTable table(std::move(options.study));
  const study::RunFacts facts{.isa = to_string(active_isa()), .threads = options.threads};
  study::StudyFolder folder(options.out, table, facts, options.fresh);

  fmt::print("{} trials in {} cells, noise bound 3 sigma, {} on {} thread{}, {} done before, writing to {}\n",
             table.size(), table.options().cells(), facts.isa, facts.threads, facts.threads == 1 ? "" : "s",
             table.filled(), options.out);
  std::fflush(stdout);
  if (!table.complete()) {
    const InterruptionGuard guard;
    Progress progress(table.size(), table.filled());
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
  fmt::print("data: {0}/trials.csv, {0}/cells.csv, {0}/summary.json\n", options.out);
  std::fflush(stdout);
  draw(options.out);
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
  command->add_option("--seed", study.seed, "Seed of the data; trial k runs its solver with seed + k")
      ->check(whole_number())
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--out", options->out, "Folder for the results, made if missing")->capture_default_str();
  command->add_flag("--fresh", options->fresh, "Start over: drop the study that the folder holds");
  command->footer(
      "Every problem has points in a cube of 200 m under one random rigid motion. A solver gets the noise bound 3 "
      "sigma;\n"
      "it succeeds when the RMSE of the true inliers is below 3 sigma. Ctrl-C keeps what is done; the same command "
      "resumes.\n"
      "Writes trials.csv, cells.csv, summary.json, and recall and errors as .svg and .png. CONSIMD_PYTHON names the "
      "Python\n"
      "that draws (it needs matplotlib), CONSIMD_PLOT_SCRIPT another script.\n"
      "Exit code: 0 when complete, 2 on bad usage, 130 when stopped.\n"
      "Examples:\n"
      "  consimd sweep                                                the paper's study: 25000 trials\n"
      "  consimd sweep --outliers 0.9,0.99 --sigma 0.5,1,2 --trials 20 --out quick");
  command->callback([&run, options] { run = [options] { return run_sweep_command(*options); }; });
}

}  // namespace consimd::cli
