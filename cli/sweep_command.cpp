#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/limits.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/study_page.hpp>
#include <consimd/studies/sweep.hpp>
#include <consimd/studies/value_list.hpp>
#include "commands.hpp"
#include "family_arguments.hpp"
#include "filter_option.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "outside_arguments.hpp"
#include "progress.hpp"
#include "report_option.hpp"
#include "shard_option.hpp"
#include "standard_streams.hpp"
#include "study_report.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  studies::SweepOptions study;
  SolverArguments solvers{study.solvers};
  std::string outliers{studies::kPaperOutlierRatios};
  std::string sigma{studies::kPaperSigmas};
  ConditionArguments conditions;
  std::string filter = "none";
  int threads = 1;
  std::string out = "consimd-sweep";
  std::optional<std::string> shard;
  bool fresh = false;
  bool map = false;
  std::string report;
};

std::vector<double> values_of(std::string_view option, const std::string& text) {
  try {
    return studies::parse_value_list(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

/// Measures those of the noise levels that the folder lacks; each is written as it ends. Whether none is left.
bool measure_limits(const studies::SweepOptions& options, const std::vector<double>& levels, std::string_view steps,
                    studies::StudyFolder& folder) {
  const std::size_t done = folder.limits().size();
  if (done == levels.size()) return true;
  const InterruptionGuard guard;
  Progress progress(levels.size() * studies::kLimitProblems, done * studies::kLimitProblems, steps);
  const studies::LimitControl control{.on_problem = [&] { progress.step(); },
                                      .stop_requested = [] { return InterruptionGuard::requested(); }};
  for (const double sigma : levels) {
    if (folder.has_limit(sigma)) continue;
    const std::optional<studies::LimitRecord> limit = studies::measure_limit(options, sigma, control);
    if (!limit) return false;
    folder.append(*limit);
  }
  return true;
}

int run_sweep_command(Options options) {
  const std::optional<studies::Shard> shard = shard_of(options.shard);
  const std::string part = shard ? fmt::format(" of shard {}", to_string(*shard)) : "";
  const std::string out = shard ? (std::filesystem::path(options.out) / folder_name(*shard)).string() : options.out;
  options.study.outlier_ratios = values_of("--outliers", options.outliers);
  options.study.sigmas = values_of("--sigma", options.sigma);
  set_conditions(options.study, options.conditions);
  if (options.map) studies::require_limits(options.study);
  StudySolvers solvers = solvers_of(options.solvers);
  options.study.solvers = std::move(solvers.names);
  options.study.outside = std::move(solvers.outside);
  options.study.filter = filter_by_name(options.filter);
  studies::TrialTable table(std::move(options.study), shard, studies::TrialTable::Keep::marks);
  const studies::RunFacts facts{.isa = to_string(active_isa()), .threads = options.threads};
  if (shard && !options.report.empty()) {
    throw std::invalid_argument("--report: a shard has no cells; consimd merge makes the report of all");
  }
  check_report(options.report, out);
  studies::StudyFolder folder(out, table, facts, options.fresh);

  fmt::print("{} trials{} in {} cells, {}, {} on {} thread{}, {} done before, writing to {}\n", table.size(), part,
             table.options().cells(), bound_text(table.options()), facts.isa, facts.threads,
             facts.threads == 1 ? "" : "s", table.filled(), out);
  flush_standard_output();
  FailureReport failures;
  if (!table.complete()) {
    const InterruptionGuard guard;
    const std::string steps = "trials" + part;
    Progress progress(table.size(), table.filled(), steps);
    const studies::SweepControl control{.on_trial =
                                            [&](const studies::TrialRecord& record) {
                                              folder.append(record);
                                              progress.step();
                                            },
                                        .on_failure = [&](const std::string& failure) { failures.add(failure); },
                                        .stop_requested = [] { return InterruptionGuard::requested(); }};
    with_threads(options.threads, [&] { studies::run_sweep(table, control); });
  }
  failures.tell_all("trials");
  if (!table.complete()) {
    tell("consimd: stopped after {} of {} trials{}; the same command resumes\n", table.filled(), table.size(), part);
    return kInterrupted;
  }
  const studies::StudySummary summary = folder.finish(table, facts);
  if (!shard) print_trials(summary);
  if (options.map) {
    const std::vector<double> levels = limit_levels(table.options(), shard);
    const std::string steps = "limit problems" + part;
    if (!with_threads(options.threads, [&] { return measure_limits(table.options(), levels, steps, folder); })) {
      tell("consimd: stopped after the limits of {} of {} noise levels{}; the same command resumes\n",
           folder.limits().size(), levels.size(), part);
      return kInterrupted;
    }
    if (!shard) print_limits(folder.limits(), table.options());
  }
  if (shard) {
    fmt::print("shard {} is complete; when all are: consimd merge {}\n", to_string(*shard), options.out);
  } else {
    // Before the figures: those of many conditions take minutes.
    write_report(options.report, [&](std::string_view command) {
      return studies::sweep_page(summary, studies::summary_json(table, {facts.isa, facts.threads, true}), command);
    });
    print_files_and_draw(out, options.map);
  }
  return kSuccess;
}

}  // namespace

void add_sweep_command(CLI::App& app, Action& run) {
  CLI::App* command =
      app.add_subcommand("sweep", "Run the noise study: recall and errors over noise and outlier ratio");
  auto options = std::make_shared<Options>();
  studies::SweepOptions& study = options->study;
  command->add_option("--outliers", options->outliers, "Outlier ratios in [0, 1): a list, or start:end:count")
      ->capture_default_str();
  command
      ->add_option("--sigma", options->sigma,
                   "Standard deviations of the inliers' noise, metres: a list, or start:end:count evenly spaced values")
      ->capture_default_str();
  command
      ->add_option("--trials", study.trials,
                   "Problems of a cell: of an outlier ratio, a noise level, and each of what follows")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  add_condition_arguments(*command, options->conditions);
  add_solver_arguments(*command, options->solvers);
  add_filter_option(*command, options->filter);
  command->add_option("--seed", study.seed, "Seed of the data; trial k runs its solver with seed + k")
      ->check(whole_number())
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--out", options->out, "Folder for the results, made if missing")->capture_default_str();
  add_shard_option(*command, options->shard);
  command->add_flag("--fresh", options->fresh, "Start over: drop the study that the folder holds");
  command->add_flag("--map", options->map,
                    "Also measure where the limit lies (limits.csv) and draw maps over outlier ratio and noise");
  add_report_option(*command, options->report);
  command->footer(
      "Every problem has points in a cube of 200 m under one random rigid motion. A solver gets the noise bound 3 "
      "sigma;\n"
      "it succeeds when the RMSE of the true inliers is below 3 sigma. Ctrl-C keeps what is done; the same command "
      "resumes.\n"
      "The paper's problems are of the family gaussian; --family, --scale, several --points, --bound-factor and\n"
      "--no-pose go beyond it, and the tables then have columns that tell of them. Families:\n" +
      family_lines() +
      "Writes trials.csv, cells.csv, summary.json, and recall and errors as .svg and .png. CONSIMD_PYTHON names the "
      "Python\n"
      "that draws (it needs matplotlib), CONSIMD_PLOT_SCRIPT another script.\n"
      "--map adds limits.csv and map.svg (and .png). Per noise level it runs the solver on 10 problems without a true\n"
      "pose: the limit is the outlier ratio at which the true pose has no more support than the best pose of these.\n"
      "--shard divides a study among machines or processes: each writes to OUT/shard-K-of-N, 'consimd merge OUT' "
      "makes\n"
      "the study of them. 'auto' takes the index of a Slurm array task (slurm-array), the rank that an MPI launcher\n"
      "gave (openmpi, pmi), or that of a Slurm step (slurm); without --shard the environment is not looked at.\n"
      "Exit code: 0 when complete, 2 on bad usage or where output cannot be written, 130 when stopped.\n"
      "Examples:\n"
      "  consimd sweep                                                # the paper's study: 25000 trials\n"
      "  consimd sweep --outliers 0.9,0.99 --sigma 0.5,1,2 --trials 20 --out quick\n"
      "  consimd sweep --solver ransac:max_iterations=10000,tcf --trials 20 --out options\n"
      "  consimd sweep --solver tcf --solver 'mine=exec:./my_solver --fast' --trials 20 --out mine\n"
      "  consimd sweep --family gaussian,heavy_tails,decoy --no-pose 0.1 --sigma 0.5,2 --trials 20 --out families\n"
      "  consimd sweep --bound-factor 0.5,1,2,estimated --points 100,1000 --outliers 0.5 --sigma 1 --out bounds\n"
      "  consimd sweep --shard 2/4                                    # a quarter of it\n"
      "  mpirun -n 4 consimd sweep --shard auto --threads 1           # four processes, then: consimd merge\n"
      "  consimd sweep --map --outliers 0.5,0.9,0.95,0.98,0.99,0.995 --sigma 0.1,0.5,1,2,5 --trials 20 --out map");
  command->callback([&run, options] { run = [options] { return run_sweep_command(*options); }; });
}

}  // namespace consimd::cli
