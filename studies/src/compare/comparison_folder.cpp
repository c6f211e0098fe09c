#include <consimd/studies/comparison_folder.hpp>

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/replace_file.hpp>
#include "files/csv_file.hpp"
#include "provenance/run_json.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kRuns = "runs.csv";
constexpr std::string_view kSummary = "comparison.json";
constexpr std::string_view kTables = "tables.md";
constexpr std::string_view kFigures[] = {"iterations.svg", "iterations.png"};
constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

Json options_json(const ComparisonFacts& facts) {
  Json json = Json::object();
  for (const auto& [name, value] : facts.options) json[name] = value;
  return json;
}

std::string summary(const Comparison& comparison, const ComparisonFacts& facts) {
  Json json = environment_json(facts.isa, facts.threads);
  json["options"] = options_json(facts);
  json["data"] = Json::array();
  for (const CaseGroup& group : comparison.groups()) {
    json["data"].push_back({{"group", group.name}, {"provenance", group.provenance}, {"cases", group.cases.size()}});
  }
  json["runs_total"] = comparison.size();
  json["runs_done"] = comparison.filled();
  json["complete"] = comparison.complete();
  return summary_text(json);
}

std::string environment_line(const ComparisonFacts& facts) {
  const Json json = environment_json(facts.isa, facts.threads);
  return fmt::format("consimd {} ({}), {} on {} thread{}, {}, {}.", json["version"].get<std::string>(),
                     json["commit"].get<std::string>(), facts.isa, facts.threads, facts.threads == 1 ? "" : "s",
                     json["compiler"].get<std::string>(), json["machine"]["cpu"].get<std::string>());
}

fs::path table_file(std::string_view name) { return fmt::format("table_{}.csv", name); }

}  // namespace

ComparisonFolder::ComparisonFolder(fs::path folder, Comparison& comparison, const ComparisonFacts& facts, bool fresh)
    : folder_(std::move(folder)) {
  require_writable_folder(folder_);
  lock_.emplace(folder_);
  if (fresh) remove_comparison();
  if (fs::exists(folder_ / kSummary) || fs::exists(folder_ / kRuns)) resume(comparison, facts);
  replace_file(folder_ / kSummary, summary(comparison, facts));
  if (comparison.filled() == 0) replace_file(folder_ / kRuns, csv_header(kRunColumns) + "\n");
  open_runs();
}

void ComparisonFolder::open_runs() { runs_.open(folder_ / kRuns, std::ios::binary | std::ios::app); }

void ComparisonFolder::remove_comparison() {
  for (const std::string_view name : {kRuns, kSummary, kTables}) fs::remove(folder_ / name);
  for (const std::string_view name : kFigures) fs::remove(folder_ / name);
  for (const TableInfo& table : paper_tables()) fs::remove(folder_ / table_file(table.name));
}

void ComparisonFolder::resume(Comparison& comparison, const ComparisonFacts& facts) {
  if (!fs::exists(folder_ / kSummary)) {
    throw std::runtime_error(
        fmt::format("{}: no {} says which comparison this is; {}", (folder_ / kRuns).string(), kSummary, kRemedy));
  }
  std::string other;
  try {
    other = difference(read_text(folder_ / kSummary), options_json(facts));
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}; {}", (folder_ / kSummary).string(), error.what(), kRemedy));
  }
  if (!other.empty()) {
    throw std::runtime_error(fmt::format("{} holds another comparison: {}; {}", folder_.string(), other, kRemedy));
  }
  if (!fs::exists(folder_ / kRuns)) return;
  for_each_whole_row(folder_ / kRuns, csv_header(kRunColumns),
                     [&](std::string_view line) { comparison.put(parse_run_row(line)); });
}

void ComparisonFolder::append(const RunRecord& record) {
  runs_ << to_csv_row(record) << std::flush;
  if (!runs_) throw std::runtime_error(fmt::format("{}: cannot write", (folder_ / kRuns).string()));
}

void ComparisonFolder::write(const Comparison& comparison, const std::vector<TextTable>& tables,
                             const ComparisonFacts& facts) {
  runs_.close();
  std::string runs = csv_header(kRunColumns) + "\n";
  for (const RunRecord& record : comparison.done()) runs += to_csv_row(record);
  replace_file(folder_ / kRuns, runs);
  open_runs();

  std::string text;
  for (const TextTable& table : tables) {
    text += fmt::format("{}\n", to_markdown(table));
    replace_file(folder_ / table_file(table.name), to_csv(table));
  }
  text += environment_line(facts) + "\n";
  replace_file(folder_ / kTables, text);
  replace_file(folder_ / kSummary, summary(comparison, facts));
}

}  // namespace consimd::studies
