#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/comparison_merge.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/shard_merge.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/study_page.hpp>
#include "commands.hpp"
#include "comparison_report.hpp"
#include "report_option.hpp"
#include "study_report.hpp"

namespace consimd::cli {
namespace fs = std::filesystem;
namespace {

struct Options {
  std::vector<std::string> folders = {"consimd-sweep"};
  std::string out;
  bool map = false;
  bool fresh = false;
  std::string report;
};

/// Where the unsharded study would be: the folder that holds all shards.
fs::path common_parent(const std::vector<fs::path>& shards) {
  const auto parent = [](const fs::path& shard) { return fs::canonical(shard).parent_path(); };
  for (const fs::path& shard : shards) {
    if (parent(shard) != parent(shards.front())) {
      throw std::runtime_error(fmt::format("--out: expected a folder, since {} and {} are not in the same one",
                                           shards.front().string(), shard.string()));
    }
  }
  fs::path named = (shards.front() / "").parent_path().parent_path();  // the first step drops a slash at the end
  if (named.empty()) named = ".";
  // As the user wrote it, unless the path ends in dots or in a link.
  return fs::canonical(named) == parent(shards.front()) ? named : parent(shards.front());
}

/// Where the whole goes.
std::string folder_of_all(const Options& options, const std::vector<fs::path>& shards) {
  std::string out = (options.out.empty() ? common_parent(shards) : fs::path(options.out)).string();
  for (const fs::path& shard : shards) {
    if (fs::weakly_canonical(out) == fs::canonical(shard)) {
      throw std::runtime_error(fmt::format("--out: {} is one of the shards", out));
    }
  }
  return out;
}

int merge_comparison(const Options& options, const std::vector<fs::path>& shards) {
  if (options.map) throw std::invalid_argument("--map: it is for shards of 'consimd sweep'");
  const studies::MergedComparison merged = studies::merge_comparisons(shards);
  const std::string out = folder_of_all(options, shards);
  check_report(options.report, out);
  const studies::ComparisonResults results = studies::comparison_results(merged.tables, merged.comparison);
  studies::write_comparison(out, merged, results, options.fresh);
  fmt::print("{} runs, merged from {} shard{}, writing to {}\n", merged.comparison.size(), shards.size(),
             shards.size() == 1 ? "" : "s", out);
  print_comparison(results, out);
  write_report(options.report, [&](std::string_view command) {
    return studies::comparison_page(merged.comparison, results, merged.summary, command);
  });
  return kSuccess;
}

int run_merge(const Options& options) {
  const std::vector<fs::path> folders(options.folders.begin(), options.folders.end());
  if (const std::vector<fs::path> of_comparison = studies::comparison_shards(folders); !of_comparison.empty()) {
    return merge_comparison(options, of_comparison);
  }
  const std::vector<fs::path> shards = studies::shard_folders(folders);
  const studies::MergedStudy merged = studies::merge_shards(shards, options.map);
  const std::string out = folder_of_all(options, shards);
  check_report(options.report, out);
  studies::write_study(out, merged.table, merged.limits, merged.summary, options.fresh);

  fmt::print("{} trials in {} cells, merged from {} shard{}, writing to {}\n", merged.table.size(),
             merged.table.options().cells(), shards.size(), shards.size() == 1 ? "" : "s", out);
  const studies::StudySummary summary = studies::summarise(merged.table);
  print_trials(summary);
  if (!merged.limits.empty()) print_limits(merged.limits, merged.table.options());
  write_report(options.report,
               [&](std::string_view command) { return studies::sweep_page(summary, merged.summary, command); });
  print_files_and_draw(out, !merged.limits.empty());
  return kSuccess;
}

}  // namespace

void add_merge_command(CLI::App& app, Action& run) {
  CLI::App* command =
      app.add_subcommand("merge", "Put a noise study or a comparison together that ran in shards (--shard)");
  auto options = std::make_shared<Options>();
  command->add_option("DIR", options->folders, "Folders of shards, or folders that hold them")->capture_default_str();
  command->add_option("--out", options->out, "Folder for the study (default: the one that holds the shards)");
  command->add_flag("--map", options->map,
                    "Insist on the limits of 'sweep --map'; where all are there they are merged");
  command->add_flag("--fresh", options->fresh, "Drop another study that --out holds");
  add_report_option(*command, options->report);
  command->footer(
      "Writes the files that the unsharded study would have written, byte for byte: trials.csv, cells.csv,\n"
      "summary.json, limits.csv of a study with --map, and the figures; of a comparison runs.csv, its tables, figures "
      "and\n"
      "comparison.json, for which the data are not needed. Times are those that the shards measured;\n"
      "summary.json lists the machines if there were several. The shards must be of one study, one division and this\n"
      "version of consimd, all there and complete; they are left as they are.\n"
      "Exit code: 0 when merged, 2 on bad usage or input.\n"
      "Examples:\n"
      "  consimd merge                                   # the shards in consimd-sweep, where sweep puts them\n"
      "  consimd merge consimd-compare                   # those of a comparison\n"
      "  consimd merge from-a/shard-1-of-2 from-b/shard-2-of-2 --out study");
  command->callback([&run, options] { run = [options] { return run_merge(*options); }; });
}

}  // namespace consimd::cli
