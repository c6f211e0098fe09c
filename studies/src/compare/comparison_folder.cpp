#include <consimd/studies/comparison_folder.hpp>

#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/text_file.hpp>

#include <consimd/studies/method.hpp>
#include <consimd/studies/paper_tables.hpp>
#include <consimd/studies/replace_file.hpp>
#include "files/csv_file.hpp"
#include "files/digest.hpp"
#include "provenance/run_json.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kRuns = "runs.csv";
constexpr std::string_view kSummary = "comparison.json";
constexpr std::string_view kTables = "tables.md";
constexpr std::string_view kFigures[] = {"iterations.svg", "iterations.png"};
constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

Json options_json(const ComparisonFacts& facts, const Comparison& comparison) {
  Json json = Json::object();
  for (const auto& [name, value] : facts.options) json[name] = value;
  if (!comparison.outside().empty()) json["outside"] = outside_json(comparison.outside());
  return json;
}

/// What the cases were read from, by their names.
Json digests_json(const CaseGroup& group) {
  Json digests = Json::object();
  for (const Case& one : group.cases) {
    if (!one.digest.empty()) digests[one.name] = one.digest;
  }
  return digests;
}

/// Hashes of the values of all options of the methods that are solvers.
Json solver_options_json(const Comparison& comparison) {
  Json digests = Json::object();
  for (const CaseGroup& group : comparison.groups()) {
    for (const std::string& method : group.methods) {
      if (outside_method(comparison.outside(), method)) continue;
      const std::string values = option_values(method);
      if (values.empty()) continue;
      Digest digest;
      digest.add(values);
      digests[method] = digest.text();
    }
  }
  return digests;
}

/// The object that `json` has as `key`, an empty one where it has none.
Json object_at(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

std::string case_difference(const Json& there, const CaseGroup& group) {
  const Json here = digests_json(group);
  for (const auto& [name, digest] : here.items()) {
    const auto found = there.find(name);
    if (found == there.end()) return fmt::format("case {} of {} is new", name, group.name);
    if (*found != digest) return fmt::format("case {} of {} has changed", name, group.name);
  }
  for (const auto& [name, digest] : there.items()) {
    if (!here.contains(name)) return fmt::format("case {} of {} is gone", name, group.name);
  }
  return {};
}

/// The first case or method of `comparison` that is not what it was when `text`, that of its summary, was written.
std::string data_difference(std::string_view text, const Comparison& comparison) {
  const Json summary = parse_json(text);
  std::map<std::string, Json> digests;
  const auto data = summary.find("data");
  for (const Json& group : data != summary.end() ? *data : Json::array()) {
    if (group.is_object() && group.contains("group") && group["group"].is_string()) {
      digests[group["group"].get<std::string>()] = object_at(group, "digests");
    }
  }
  for (const CaseGroup& group : comparison.groups()) {
    const auto there = digests.find(group.name);
    const Json none = Json::object();
    if (std::string what = case_difference(there == digests.end() ? none : there->second, group); !what.empty()) {
      return what;
    }
  }
  const Json options = object_at(summary, "solver_options");
  const Json here = solver_options_json(comparison);
  for (const auto& [method, digest] : here.items()) {
    if (options.value(method, Json()) != digest) return fmt::format("{} had other options", method);
  }
  return {};
}

std::string summary(const Comparison& comparison, const ComparisonFacts& facts) {
  Json json = environment_json(facts.isa, facts.threads);
  json["options"] = options_json(facts, comparison);
  json["data"] = Json::array();
  for (const CaseGroup& group : comparison.groups()) {
    json["data"].push_back({{"group", group.name}, {"provenance", group.provenance}, {"cases", group.cases.size()}});
    if (Json digests = digests_json(group); !digests.empty()) json["data"].back()["digests"] = std::move(digests);
  }
  json["solver_options"] = solver_options_json(comparison);
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
    const std::string text = synth::read_text(folder_ / kSummary);
    other = difference(text, options_json(facts, comparison));
    if (other.empty()) other = data_difference(text, comparison);
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
