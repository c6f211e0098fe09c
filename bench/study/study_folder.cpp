#include "study/study_folder.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "study/cell_summary.hpp"
#include "study/csv_file.hpp"
#include "study/replace_file.hpp"

namespace consimd::study {
namespace fs = std::filesystem;
using namespace std::string_view_literals;
namespace {

constexpr std::string_view kTrials = "trials.csv";
constexpr std::string_view kCells = "cells.csv";
constexpr std::string_view kLimits = "limits.csv";
constexpr std::string_view kSummary = "summary.json";
constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

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
  for (const std::string_view name : {kTrials, kCells, kLimits, kSummary, "recall.svg"sv, "recall.png"sv,
                                      "errors.svg"sv, "errors.png"sv, "map.svg"sv, "map.png"sv}) {
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
  if (fs::exists(folder_ / kLimits)) read_limits(table.options());
}

void StudyFolder::read_trials(TrialTable& table) {
  for_each_whole_row(folder_ / kTrials, kTrialColumns,
                     [&](std::string_view line) { table.put(parse_trial_row(line)); });
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

void StudyFolder::read_limits(const SweepOptions& options) {
  const fs::path path = folder_ / kLimits;
  for_each_row(path, read_text(path), kLimitColumns, [&](std::string_view line) {
    const LimitRecord limit = parse_limit_row(line);
    if (limit.problems != kLimitProblems || std::ranges::count(options.sigmas, limit.sigma) == 0 ||
        std::ranges::count(limits_, limit.sigma, &LimitRecord::sigma) != 0) {
      throw std::invalid_argument(
          fmt::format("noise level {} with {} problems is not of this study", limit.sigma, limit.problems));
    }
    limits_.push_back(limit);
  });
}

void StudyFolder::append(const LimitRecord& limit) {
  limits_.push_back(limit);
  std::string text = fmt::format("{}\n", kLimitColumns);
  for (const LimitRecord& row : limits_) text += to_csv_row(row);
  replace_file(folder_ / kLimits, text);
}

}  // namespace consimd::study
