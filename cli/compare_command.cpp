#include <algorithm>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/synth/stand_ins.hpp>

#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/figures.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/value_list.hpp>
#include "case_folder.hpp"
#include "commands.hpp"
#include "figure_report.hpp"
#include "filter_option.hpp"
#include "interruption.hpp"
#include "option_checks.hpp"
#include "progress.hpp"
#include "threads.hpp"

namespace consimd::cli {
namespace {

struct Options {
  std::string cases;
  std::vector<std::string> synthetic;
  std::uint32_t trials = 20;
  std::size_t points = 3000;
  std::string outliers = "0.1,0.5,0.9,0.95,0.98,0.99";
  std::string sigma = "0.1,1,2.5,5";
  studies::TableOptions tables{.tables = {"solvers"},
                               .solvers = {},
                               .iterations = {1000, 3000, 10'000, 30'000, 100'000, 300'000, 1'000'000},
                               .scales = {0.2, 0.5, 1.0, 2.0, 5.0}};
  std::uint32_t iteration_problems = 200;
  std::string filter = "none";
  std::uint64_t seed = 1;
  std::uint32_t seeds = 1;
  int threads = 1;
  std::string out = "consimd-compare";
  bool fresh = false;
};

std::vector<double> values_of(std::string_view option, const std::string& text) {
  try {
    return studies::parse_value_list(text);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

/// Names of stand-ins, with "stand-ins", "eth" and "kitti" spelt out, each once, in the paper's order; and whether
/// "noise" is among them.
struct Synthetic {
  std::vector<std::string> stand_ins;
  bool noise = false;
};

Synthetic synthetic_of(const std::vector<std::string>& words) {
  Synthetic result;
  const auto asked_for = [&](std::string_view word) { return std::ranges::find(words, word) != words.end(); };
  for (const synth::StandIn& s : synth::stand_ins()) {
    const std::string_view set = s.dataset == "ETH" ? "eth" : "kitti";
    if (asked_for("stand-ins") || asked_for(set) || asked_for(s.name)) result.stand_ins.emplace_back(s.name);
  }
  result.noise = asked_for("noise");
  for (const std::string& word : words) {
    if (word == "stand-ins" || word == "eth" || word == "kitti" || word == "noise") continue;
    try {
      static_cast<void>(synth::stand_in(word));
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--synthetic: {}, or stand-ins, eth, kitti, noise", error.what()));
    }
  }
  return result;
}

std::vector<studies::CaseGroup> groups_of(const Options& options) {
  const studies::TableOptions& tables = options.tables;
  std::vector<studies::CaseGroup> groups;
  const std::vector<std::string> methods = studies::methods_of(tables);
  if (!methods.empty()) {
    if (!options.cases.empty()) groups = case_folder_groups(options.cases, options.seed, tables.preset);
    std::vector<std::string> words = options.synthetic;
    if (words.empty() && options.cases.empty()) words = {"stand-ins"};
    const Synthetic synthetic = synthetic_of(words);
    std::ranges::move(studies::stand_in_groups(synthetic.stand_ins, options.trials, options.seed, tables.preset),
                      std::back_inserter(groups));
    if (synthetic.noise) {
      std::ranges::move(studies::noise_groups({.points = options.points,
                                               .outlier_ratios = values_of("--outliers", options.outliers),
                                               .sigmas = values_of("--sigma", options.sigma),
                                               .trials = options.trials,
                                               .seed = options.seed}),
                        std::back_inserter(groups));
    }
    for (studies::CaseGroup& group : groups) group.methods = methods;
  }
  if (!studies::iteration_methods(tables).empty()) {
    groups.push_back(studies::iteration_group(tables, options.iteration_problems, options.seed));
  }
  std::ranges::move(studies::scale_groups(tables, options.trials, options.seed), std::back_inserter(groups));
  return groups;
}

/// All that decides what is run, as text.
std::vector<studies::OptionText> option_texts(const Options& o) {
  return {{"cases", o.cases},
          {"synthetic", fmt::format("{}", fmt::join(o.synthetic, ","))},
          {"trials", fmt::format("{}", o.trials)},
          {"points", fmt::format("{}", o.points)},
          {"outliers", o.outliers},
          {"sigma", o.sigma},
          {"table", fmt::format("{}", fmt::join(o.tables.tables, ","))},
          {"solver", fmt::format("{}", fmt::join(o.tables.solvers, ","))},
          {"filter", o.filter},
          {"thresholds", o.tables.preset},
          {"iterations", fmt::format("{}", fmt::join(o.tables.iterations, ","))},
          {"scales", fmt::format("{}", fmt::join(o.tables.scales, ","))},
          {"iteration-problems", fmt::format("{}", o.iteration_problems)},
          {"seed", fmt::format("{}", o.seed)},
          {"seeds", fmt::format("{}", o.seeds)}};
}

int run_compare(Options options) {
  studies::TableOptions& tables = options.tables;
  tables.filtered = filter_by_name(options.filter) == Filter::tcf;
  studies::validate(tables);
  if (tables.filtered && std::ranges::count(tables.tables, "solvers") == 0) {
    throw std::invalid_argument("--filter: it is for the table solvers; boost runs with and without");
  }
  studies::Comparison comparison(groups_of(options), options.seeds);
  const studies::ComparisonFacts facts{
      .options = option_texts(options), .isa = to_string(active_isa()), .threads = options.threads};
  studies::ComparisonFolder folder(options.out, comparison, facts, options.fresh);

  fmt::print("{} runs on {} groups of cases, {} on {} thread{}, {} done before, writing to {}\n", comparison.size(),
             comparison.groups().size(), facts.isa, facts.threads, facts.threads == 1 ? "" : "s", comparison.filled(),
             options.out);
  std::fflush(stdout);
  if (!comparison.complete()) {
    const InterruptionGuard guard;
    Progress progress(comparison.size(), comparison.filled(), "runs");
    const studies::ComparisonControl control{.on_run =
                                                 [&](const studies::RunRecord& record) {
                                                   folder.append(record);
                                                   progress.step();
                                                 },
                                             .stop_requested = [] { return InterruptionGuard::requested(); }};
    with_threads(options.threads, [&] { studies::run_comparison(comparison, control); });
  }
  const std::vector<studies::TextTable> results = studies::make_tables(tables, comparison);
  folder.write(comparison, results, facts);
  if (!comparison.complete()) {
    fmt::print(stderr, "consimd: stopped after {} of {} runs; the same command resumes\n", comparison.filled(),
               comparison.size());
    return kInterrupted;
  }
  for (const studies::TextTable& table : results) fmt::print("\n{}", studies::to_markdown(table));
  fmt::print("\ndata: {0}/runs.csv, {0}/comparison.json, {0}/tables.md and a table_*.csv a table\n", options.out);
  if (std::ranges::count(tables.tables, "iterations") != 0) {
    draw_and_name_figures(studies::kIterationsScript, options.out, {"iterations"});
  }
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
  for (const SolverInfo& solver : solvers()) options->tables.solvers.emplace_back(solver.name);
  command->add_option("--cases", options->cases,
                      "Folder of cases: sub-folders with correspondences.txt, pose.txt and case.json");
  command
      ->add_option("--synthetic", options->synthetic,
                   "Synthetic sets, separated by commas: stand-ins (all ten), eth, kitti, single ones (arch, kitti01, "
                   "...), noise (cells of the noise study); default: stand-ins, if there are no --cases")
      ->delimiter(',');
  command->add_option("--trials", options->trials, "Problems of each stand-in, noise cell and scale with its noise")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--points", options->points, "Correspondences of a noise cell's problem")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--outliers", options->outliers, "Outlier ratios of the noise cells")->capture_default_str();
  command->add_option("--sigma", options->sigma, "Noise of the noise cells, metres an axis")->capture_default_str();
  command->add_option("--table", options->tables.tables, "Tables to make, separated by commas; listed below")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--solver", options->tables.solvers, "Solvers, separated by commas; 'consimd info' lists them")
      ->delimiter(',')
      ->capture_default_str();
  add_filter_option(*command, options->filter);
  command->add_option("--thresholds", options->tables.preset, "Limits of a success; listed below")
      ->capture_default_str();
  command->add_option("--iterations", options->tables.iterations, "Samples of plain RANSAC, for the table of that name")
      ->delimiter(',')
      ->check(whole_number(1, 4'294'967'295))
      ->capture_default_str();
  command->add_option("--iteration-problems", options->iteration_problems, "Problems of that table")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--scales", options->tables.scales, "Scales of the source, for the table of that name")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of the data; synthetic problem k starts its solvers with seed + k")
      ->check(whole_number())
      ->capture_default_str();
  command->add_option("--seeds", options->seeds, "Runs of a solver on each case, with seeds one after the other")
      ->check(whole_number(1, 1'000'000))
      ->capture_default_str();
  add_threads_option(*command, options->threads);
  command->add_option("--out", options->out, "Folder for the results, made if missing")->capture_default_str();
  command->add_flag("--fresh", options->fresh, "Start over: drop the comparison that the folder holds");
  command->footer(fmt::format(
      "Runs go one at a time, each on all threads. Ctrl-C keeps what is done and writes the tables of it; the same\n"
      "command resumes. Writes runs.csv (a row a run), tables.md, a table_*.csv a table, and comparison.json;\n"
      "the table iterations comes with a figure, iterations.svg and .png, drawn like those of consimd sweep.\n"
      "A case.json holds noise_bound, max_rotation_error_deg, max_translation_error_m and, for the grouping, dataset "
      "and\nsequence. Noise cells succeed when the RMSE of the true inliers is below the noise bound.\n"
      "Tables:\n{}Thresholds:\n{}"
      "Exit code: 0 when complete, 2 on bad usage or input, 130 when stopped.\n"
      "Examples:\n"
      "  consimd compare --cases kitti --thresholds kitti06 --seeds 5      your own files\n"
      "  consimd compare --synthetic eth --solver tcf,ransac-50k           stand-ins for the paper's ETH scans\n"
      "  consimd compare --table boost,stages,poses --synthetic trees,kitti01\n"
      "  consimd compare --table iterations\n"
      "  consimd compare --table scales --solver pcr99,teaser",
      listed(studies::paper_tables()), listed(studies::limit_presets())));
  command->callback([&run, options] { run = [options] { return run_compare(*options); }; });
}

}  // namespace consimd::cli
