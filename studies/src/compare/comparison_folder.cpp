#include <consimd/studies/comparison_folder.hpp>

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/text_file.hpp>

#include <consimd/studies/comparison_merge.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/replace_file.hpp>
#include "compare/comparison_summary.hpp"
#include "files/csv_file.hpp"
#include "provenance/run_json.hpp"
#include "statistics/comparison_files.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
using namespace detail;
namespace {

constexpr std::string_view kTables = "tables.md";
constexpr std::string_view kFigures[] = {"iterations.svg", "iterations.png"};
constexpr std::string_view kCorrespondences = "correspondences";
constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

fs::path table_file(std::string_view name) { return fmt::format("table_{}.csv", name); }

void remove_comparison(const fs::path& folder) {
  for (const std::string_view name : {kRunsFile, kComparisonFile, kTables}) fs::remove(folder / name);
  for (const std::string_view name : kFigures) fs::remove(folder / name);
  for (const TableInfo& table : paper_tables()) fs::remove(folder / table_file(table.name));
  for (const std::string_view name : kSolverComparisonFiles) fs::remove(folder / name);
  fs::remove_all(folder / kCorrespondences);
}

/// Throws unless the folder holds `comparison`, or nothing that is one.
void require_same_comparison(const fs::path& folder, const Json& options, const Comparison& comparison) {
  if (!fs::exists(folder / kComparisonFile)) {
    if (!fs::exists(folder / kRunsFile)) return;
    throw std::runtime_error(fmt::format("{}: no {} says which comparison this is; {}", (folder / kRunsFile).string(),
                                         kComparisonFile, kRemedy));
  }
  std::string other;
  try {
    other = comparison_difference(synth::read_text(folder / kComparisonFile), options, comparison);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}; {}", (folder / kComparisonFile).string(), error.what(), kRemedy));
  }
  if (!other.empty()) {
    throw std::runtime_error(fmt::format("{} holds another comparison: {}; {}", folder.string(), other, kRemedy));
  }
}

std::string runs_text(const Comparison& comparison) {
  std::string runs = csv_header(kRunColumns) + "\n";
  for (const RunRecord& record : comparison.done()) runs += to_csv_row(record);
  return runs;
}

void write_results(const fs::path& folder, const ComparisonResults& results, const Json& summary) {
  std::string text;
  for (const TextTable& table : results.tables) {
    text += fmt::format("{}\n", to_markdown(table));
    replace_file(folder / table_file(table.name), to_csv(table));
  }
  replace_file(folder / kTables, text + environment_line(summary) + "\n");
  if (!results.methods.pairs.empty()) write_solver_comparison(folder, results.methods);
}

Json summary_of(const Comparison& comparison, const ComparisonFacts& facts) {
  return comparison_json(environment_json(facts.isa, facts.threads), options_json(facts.options, comparison.outside()),
                         comparison);
}

}  // namespace

fs::path correspondences_folder(const fs::path& folder) { return folder / kCorrespondences; }

std::string comparison_json(const Comparison& comparison, const ComparisonFacts& facts) {
  return summary_text(summary_of(comparison, facts));
}

ComparisonFolder::ComparisonFolder(fs::path folder, Comparison& comparison, const ComparisonFacts& facts, bool fresh)
    : folder_(std::move(folder)) {
  require_writable_folder(folder_);
  lock_.emplace(folder_);
  if (fresh) remove_comparison(folder_);
  resume(comparison, facts);
  replace_file(folder_ / kComparisonFile, comparison_json(comparison, facts));
  if (comparison.filled() == 0) replace_file(folder_ / kRunsFile, csv_header(kRunColumns) + "\n");
  open_runs();
}

void ComparisonFolder::open_runs() { runs_.open(folder_ / kRunsFile, std::ios::binary | std::ios::app); }

void ComparisonFolder::resume(Comparison& comparison, const ComparisonFacts& facts) {
  require_same_comparison(folder_, options_json(facts.options, comparison.outside()), comparison);
  if (!fs::exists(folder_ / kRunsFile)) return;
  for_each_whole_row(folder_ / kRunsFile, csv_header(kRunColumns),
                     [&](std::string_view line) { comparison.put(parse_run_row(line)); });
}

void ComparisonFolder::append(const RunRecord& record) {
  runs_ << to_csv_row(record) << std::flush;
  if (!runs_) throw std::runtime_error(fmt::format("{}: cannot write", (folder_ / kRunsFile).string()));
}

void ComparisonFolder::write(const Comparison& comparison, const ComparisonResults& results,
                             const ComparisonFacts& facts) {
  runs_.close();
  replace_file(folder_ / kRunsFile, runs_text(comparison));
  open_runs();
  const Json summary = summary_of(comparison, facts);
  if (!comparison.shard()) write_results(folder_, results, summary);
  replace_file(folder_ / kComparisonFile, summary_text(summary));
}

void write_comparison(const fs::path& folder, const MergedComparison& merged, const ComparisonResults& results,
                      bool fresh) {
  Json summary = parse_json(merged.summary);
  require_writable_folder(folder);
  const FolderLock lock(folder);
  if (fresh) remove_comparison(folder);
  require_same_comparison(folder, summary.at("options"), merged.comparison);
  // Whoever is stopped on the way leaves a comparison that can be taken up.
  summary["complete"] = false;
  replace_file(folder / kComparisonFile, summary_text(summary));
  replace_file(folder / kRunsFile, runs_text(merged.comparison));
  write_results(folder, results, summary);
  replace_file(folder / kComparisonFile, merged.summary);
}

}  // namespace consimd::studies
