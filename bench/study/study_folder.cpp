#include "study/study_folder.hpp"

#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "study/cell_summary.hpp"
#include "study/replace_file.hpp"

namespace consimd::study {
namespace fs = std::filesystem;
using namespace std::string_view_literals;
namespace {

constexpr std::string_view kTrials = "trials.csv";
constexpr std::string_view kCells = "cells.csv";
constexpr std::string_view kSummary = "summary.json";
constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) throw std::runtime_error(fmt::format("{}: cannot read", path.string()));
  return text;
}

}  // namespace

StudyFolder::StudyFolder(fs::path folder, TrialTable& table, const RunFacts& facts, bool fresh)
    : folder_(std::move(folder)) {
  require_writable_folder(folder_);
  if (fresh) remove_study();
  if (fs::exists(folder_ / kSummary) || fs::exists(folder_ / kTrials)) resume(table);

  RunFacts start = facts;
  start.trials_done = table.filled();
  replace_file(folder_ / kSummary, summary_json(table.options(), start));
  if (table.filled() == 0) replace_file(folder_ / kTrials, fmt::format("{}\n", kTrialColumns));
  trials_.open(folder_ / kTrials, std::ios::binary | std::ios::app);
}

void StudyFolder::remove_study() {
  for (const std::string_view name :
       {kTrials, kCells, kSummary, "recall.svg"sv, "recall.png"sv, "errors.svg"sv, "errors.png"sv}) {
    fs::remove(folder_ / name);
  }
}

void StudyFolder::resume(TrialTable& table) {
  if (!fs::exists(folder_ / kSummary)) {
    throw std::runtime_error(
        fmt::format("{}: no {} says which study this is; {}", (folder_ / kTrials).string(), kSummary, kRemedy));
  }
  std::string other;
  try {
    other = difference(read_text(folder_ / kSummary), table.options());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}; {}", (folder_ / kSummary).string(), error.what(), kRemedy));
  }
  if (!other.empty())
    throw std::runtime_error(fmt::format("{} holds another study: {}; {}", folder_.string(), other, kRemedy));
  if (fs::exists(folder_ / kTrials)) read_trials(table);
}

void StudyFolder::read_trials(TrialTable& table) {
  const fs::path path = folder_ / kTrials;
  const std::string text = read_text(path);
  const std::size_t whole = text.rfind('\n') + 1;  // npos + 1 is 0: no whole line
  std::string_view rest = std::string_view(text).substr(0, whole);
  for (std::size_t number = 1; !rest.empty(); ++number) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(line.size() + 1);
    try {
      if (number > 1) {
        table.put(parse_trial_row(line));
      } else if (line != kTrialColumns) {
        throw std::invalid_argument("not the header of a noise study");
      }
    } catch (const std::invalid_argument& error) {
      throw std::runtime_error(fmt::format("{}:{}: {}; --fresh starts over", path.string(), number, error.what()));
    }
  }
  fs::resize_file(path, whole);
}

void StudyFolder::append(const TrialRecord& record) {
  trials_ << to_csv_row(record) << std::flush;
  if (!trials_) throw std::runtime_error(fmt::format("{}: cannot write", (folder_ / kTrials).string()));
}

void StudyFolder::finish(const TrialTable& table, RunFacts facts) {
  trials_.close();
  std::string trials = fmt::format("{}\n", kTrialColumns);
  for (const TrialRecord& record : table.records()) trials += to_csv_row(record);
  replace_file(folder_ / kTrials, trials);

  std::string cells = fmt::format("{}\n", kCellColumns);
  for (const CellSummary& cell : summarise_cells(table)) cells += to_csv_row(cell);
  replace_file(folder_ / kCells, cells);

  facts.trials_done = table.filled();
  facts.complete = true;
  replace_file(folder_ / kSummary, summary_json(table.options(), facts));
}

}  // namespace consimd::study
