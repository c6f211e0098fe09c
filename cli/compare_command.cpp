#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/solver.hpp>

#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/study_page.hpp>
#include "commands.hpp"
#include "comparison_report.hpp"
#include "filter_option.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "outside_arguments.hpp"
#include "progress.hpp"
#include "report_option.hpp"
#include "scan_arguments.hpp"
#include "shard_option.hpp"
#include "standard_streams.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  studies::CompareOptions study;
  SolverArguments solvers{study.tables.solvers};
  ScanArguments scans;
  std::optional<std::string> shard;
  std::string filter = "none";
  int threads = 1;
  std::string out = "consimd-compare";
  bool fresh = false;
  std::string report;
};

/// Puts the comparison together. Scans take a while to read, which is told where it is more than a moment.
studies::Comparison prepared(const Options& options, const std::optional<studies::Shard>& shard,
                             std::vector<std::string>& notes) {
  constexpr std::chrono::seconds kMoment(2);
  const auto start = std::chrono::steady_clock::now();
  std::optional<Progress> progress;
  const studies::PreparationControl control{
      .on_scan =
          [&](std::size_t done, std::size_t all) {
            if (progress) {
              progress->step();
            } else if (done < all && std::chrono::steady_clock::now() - start > kMoment) {
              progress.emplace(all, done, "scans read");
            }
          },
      .on_note = [&](const std::string& note) { notes.push_back(note); }};
  return with_threads(options.threads, [&] { return studies::make_comparison(options.study, shard, control); });
}

int run_compare(const CLI::App& app, Options options) {
  const std::optional<studies::Shard> shard = shard_of(options.shard);
  if (shard && !options.report.empty()) {
    throw std::invalid_argument("--report: a shard has no tables; consimd merge makes the report of all");
  }
  const std::string part = shard ? fmt::format(" of shard {}", to_string(*shard)) : "";
  const std::string out = shard ? (std::filesystem::path(options.out) / folder_name(*shard)).string() : options.out;
  options.study.scans = scans_of(app, options.scans, studies::correspondences_folder(out).string());
  studies::TableOptions& tables = options.study.tables;
  StudySolvers solvers = solvers_of(options.solvers);
  tables.solvers = std::move(solvers.names);
  tables.outside = std::move(solvers.outside);
  tables.filtered = filter_by_name(options.filter) == Filter::tcf;
  std::vector<std::string> notes;
  studies::Comparison comparison = prepared(options, shard, notes);
  const studies::ComparisonFacts facts{
      .options = studies::option_texts(options.study), .isa = to_string(active_isa()), .threads = options.threads};
  check_report(options.report, out);
  studies::ComparisonFolder folder(out, comparison, facts, options.fresh);

  fmt::print("{} runs{} on {} group{} of cases, {} on {} thread{}, {} done before, writing to {}\n", comparison.size(),
             part, comparison.groups().size(), comparison.groups().size() == 1 ? "" : "s", facts.isa, facts.threads,
             facts.threads == 1 ? "" : "s", comparison.filled(), out);
  for (const std::string& note : notes) fmt::print("{}\n", note);
  flush_standard_output();
  FailureReport failures;
  if (!comparison.complete()) {
    const InterruptionGuard guard;
    const std::string steps = "runs" + part;
    Progress progress(comparison.size(), comparison.filled(), steps);
    const studies::ComparisonControl control{.on_run =
                                                 [&](const studies::RunRecord& record) {
                                                   folder.append(record);
                                                   progress.step();
                                                 },
                                             .on_failure = [&](const std::string& failure) { failures.add(failure); },
                                             .stop_requested = [] { return InterruptionGuard::requested(); }};
    with_threads(options.threads, [&] { studies::run_comparison(comparison, control); });
  }
  failures.tell_all("runs");
  const studies::ComparisonResults results =
      shard ? studies::ComparisonResults() : studies::comparison_results(tables, comparison);
  folder.write(comparison, results, facts);
  const auto report = [&] {
    write_report(options.report, [&](std::string_view command) {
      return studies::comparison_page(comparison, results, studies::comparison_json(comparison, facts), command);
    });
  };
  if (!comparison.complete()) {
    report();
    tell("consimd: stopped after {} of {} runs{}; the same command resumes\n", comparison.filled(), comparison.size(),
         part);
    return kInterrupted;
  }
  if (shard) {
    fmt::print("shard {} is complete; when all are: consimd merge {}\n", to_string(*shard), options.out);
  } else {
    print_comparison(results, out);
  }
  report();
  return kSuccess;
}

template <typename Infos>
std::string listed(const Infos& infos) {
  std::string text;
  for (const auto& info : infos) text += fmt::format("  {:<12} {}\n", info.name, info.description);
  return text;
}

}  // namespace

void add_compare_command(CLI::App& app, Action& run) {
  CLI::App* command =
      app.add_subcommand("compare", "Compare solvers on files and synthetic data: the tables of the TCF paper");
  auto options = std::make_shared<Options>();
  studies::CompareOptions& study = options->study;
  command->add_option("--cases", study.cases,
                      "Folder of cases: sub-folders with correspondences.txt, pose.txt and case.json");
  add_scan_options(*command, options->scans);
  command
      ->add_option(
          "--synthetic", study.synthetic,
          "Synthetic sets, separated by commas: stand-ins (all ten), eth, kitti, single ones (arch, kitti01, "
          "...), noise (cells of the noise study); default: stand-ins, if there are neither --cases nor --scans")
      ->delimiter(',');
  command->add_option("--trials", study.trials, "Problems of each stand-in, noise cell and scale with its noise")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--points", study.points, "Correspondences of a noise cell's problem")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--outliers", study.outliers, "Outlier ratios of the noise cells")->capture_default_str();
  command->add_option("--sigma", study.sigma, "Noise of the noise cells, metres an axis")->capture_default_str();
  command->add_option("--table", study.tables.tables, "Tables to make, separated by commas; listed below")
      ->delimiter(',')
      ->capture_default_str();
  add_solver_arguments(*command, options->solvers);
  add_filter_option(*command, options->filter);
  command
      ->add_option("--thresholds", study.tables.preset, "Limits of a success: DEGREES,METRES, or a name listed below")
      ->capture_default_str();
  command->add_option("--iterations", study.tables.iterations, "Samples of plain RANSAC, for the table of that name")
      ->delimiter(',')
      ->check(whole_number(1, 4'294'967'295))
      ->capture_default_str();
  command->add_option("--iteration-problems", study.iteration_problems, "Problems of that table")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--scales", study.tables.scales, "Scales of the source, for the table of that name")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--seed", study.seed, "Seed of the data; synthetic problem k starts its solvers with seed + k")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--seeds", study.seeds, "Runs of a solver on each case, with seeds one after the other")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  add_shard_option(*command, options->shard);
  command->add_option("--out", options->out, "Folder for the results, made if missing")->capture_default_str();
  command->add_flag("--fresh", options->fresh, "Start over: drop the comparison that the folder holds");
  add_report_option(*command, options->report);
  command->footer(fmt::format(
      "Runs go one at a time, each on all threads. Ctrl-C keeps what is done and writes the tables of it; the same\n"
      "command resumes. Writes runs.csv (a row a run), tables.md, a table_*.csv a table, and comparison.json;\n"
      "the table iterations comes with a figure, iterations.svg and .png, drawn like those of consimd sweep.\n"
      "Where several methods ran on the same cases they are compared case by case: pairs.csv (McNemar's test, Holm's\n"
      "adjustment, paired bootstrap), solvers.csv (quantiles, efficiency, time to reach a recall), curves.csv (recall\n"
      "over the limit of success) and comparison.svg and .png.\n"
      "A case.json holds noise_bound, max_rotation_error_deg, max_translation_error_m and, for the grouping, dataset "
      "and\nsequence. Noise cells succeed when the RMSE of the true inliers is below the noise bound.\n"
      "With --scans correspondences are made first, with the voxels, points and matches that the data set's users "
      "take\n"
      "and kept in OUT/correspondences, which --cases reads as well. Every scan is read before anything runs.\n"
      "A pairs.csv has the columns source, target and pose (a file, or 12 or 16 numbers with blanks between them) "
      "and,\n"
      "if need be, group, name, max_rotation_error_deg and max_translation_error_m; without limits success is as of\n"
      "noise cells. --shard divides the cases among machines or processes: each writes to OUT/shard-K-of-N,\n"
      "'consimd merge OUT' makes the comparison of them.\n"
      "Layouts:\n{}Tables:\n{}Thresholds:\n{}"
      "Exit code: 0 when complete, 2 on bad usage or input, 130 when stopped.\n"
      "Examples:\n"
      "  consimd compare --cases kitti --thresholds kitti06 --seeds 5      # your own files\n"
      "  consimd compare --scans KITTI --layout kitti --sequences 01,02,03,06,09    # the paper's pairs, thresholds, "
      "tables\n"
      "  consimd compare --scans 3DMatch --layout 3dmatch --table solvers,pipeline --solver tcf\n"
      "  consimd compare --scans mine --layout pairs --voxel 0.2 --thresholds 5,0.6\n"
      "  consimd compare --synthetic eth --solver tcf,ransac-50k           # stand-ins for the paper's ETH scans\n"
      "  consimd compare --table boost,stages,poses --synthetic trees,kitti01\n"
      "  consimd compare --solver ransac:max_iterations=10000:confidence=none,ransac,tcf\n"
      "  consimd compare --synthetic eth --solver tcf --solver 'mine=exec:./my_solver --fast'\n"
      "  consimd compare --table iterations\n"
      "  consimd compare --table scales --solver pcr99,teaser",
      listed(studies::scan_layouts()), listed(studies::paper_tables()), listed(studies::limit_presets())));
  command->callback([&run, options, command] { run = [options, command] { return run_compare(*command, *options); }; });
}

}  // namespace consimd::cli
