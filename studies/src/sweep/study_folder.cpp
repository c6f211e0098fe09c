#include <consimd/studies/study_folder.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/replace_file.hpp>
#include "files/csv_file.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
using namespace std::string_view_literals;
namespace {

constexpr std::string_view kRemedy = "give the same options, another --out, or --fresh to start over";

void remove_study(const fs::path& folder) {
  for (const std::string_view name : {kTrialsFile, kCellsFile, kLimitsFile, kSummaryFile, "recall.svg"sv,
                                      "recall.png"sv, "errors.svg"sv, "errors.png"sv, "map.svg"sv, "map.png"sv}) {
    fs::remove(folder / name);
  }
}

bool holds_study(const fs::path& folder) {
  return fs::exists(folder / kSummaryFile) || fs::exists(folder / kTrialsFile);
}

/// Throws unless the study in `folder` is that of `table`.
void require_same_study(const fs::path& folder, const TrialTable& table) {
  if (!fs::exists(folder / kSummaryFile)) {
    throw std::runtime_error(
        fmt::format("{}: no {} says which study this is; {}", (folder / kTrialsFile).string(), kSummaryFile, kRemedy));
  }
  std::string other;
  try {
    other = difference(read_text(folder / kSummaryFile), table);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}; {}", (folder / kSummaryFile).string(), error.what(), kRemedy));
  }
  if (!other.empty()) {
    throw std::runtime_error(fmt::format("{} holds another study: {}; {}", folder.string(), other, kRemedy));
  }
}

void write_tables(const fs::path& folder, const TrialTable& table) {
  std::string trials = csv_header(kTrialColumns) + "\n";
  table.for_each([&](const TrialRecord& record) { trials += to_csv_row(record); });
  replace_file(folder / kTrialsFile, trials);

  if (table.shard()) return;
  std::string cells = csv_header(kCellColumns) + "\n";
  for (const CellSummary& cell : summarise_cells(table)) cells += to_csv_row(cell);
  replace_file(folder / kCellsFile, cells);
}

void write_limits(const fs::path& folder, const std::vector<LimitRecord>& limits) {
  std::string text = csv_header(kLimitColumns) + "\n";
  for (const LimitRecord& row : limits) text += to_csv_row(row);
  replace_file(folder / kLimitsFile, text);
}

}  // namespace

StudyFolder::StudyFolder(fs::path folder, TrialTable& table, const RunFacts& facts, bool fresh)
    : folder_(std::move(folder)) {
  require_writable_folder(folder_);
  lock_.emplace(folder_);
  if (fresh) remove_study(folder_);
  if (holds_study(folder_)) resume(table);

  replace_file(folder_ / kSummaryFile, summary_json(table, facts));
  if (table.filled() == 0) replace_file(folder_ / kTrialsFile, csv_header(kTrialColumns) + "\n");
  trials_.open(folder_ / kTrialsFile, std::ios::binary | std::ios::app);
}

void StudyFolder::resume(TrialTable& table) {
  require_same_study(folder_, table);
  if (fs::exists(folder_ / kTrialsFile)) read_trials(table);
  if (fs::exists(folder_ / kLimitsFile)) read_limits(table);
}

void StudyFolder::read_trials(TrialTable& table) {
  for_each_whole_row(folder_ / kTrialsFile, csv_header(kTrialColumns),
                     [&](std::string_view line) { table.put(parse_trial_row(line)); });
}

void StudyFolder::append(const TrialRecord& record) {
  trials_ << to_csv_row(record) << std::flush;
  if (!trials_) throw std::runtime_error(fmt::format("{}: cannot write", (folder_ / kTrialsFile).string()));
}

void StudyFolder::finish(const TrialTable& table, RunFacts facts) {
  trials_.close();
  write_tables(folder_, table);
  facts.complete = true;
  replace_file(folder_ / kSummaryFile, summary_json(table, facts));
}

void StudyFolder::read_limits(const TrialTable& table) {
  const fs::path path = folder_ / kLimitsFile;
  const std::vector<double> levels = limit_levels(table.options(), table.shard());
  for_each_row(path, read_text(path), csv_header(kLimitColumns), [&](std::string_view line) {
    const LimitRecord limit = parse_limit_row(line);
    if (limit.problems != kLimitProblems || std::ranges::count(levels, limit.sigma) == 0 ||
        std::ranges::count(limits_, limit.sigma, &LimitRecord::sigma) != 0) {
      throw std::invalid_argument(
          fmt::format("noise level {} with {} problems is not of this study", limit.sigma, limit.problems));
    }
    limits_.push_back(limit);
  });
}

void StudyFolder::append(const LimitRecord& limit) {
  limits_.push_back(limit);
  write_limits(folder_, limits_);
}

void write_study(const fs::path& folder, const TrialTable& table, const std::vector<LimitRecord>& limits,
                 std::string_view summary, bool fresh) {
  require_writable_folder(folder);
  const FolderLock lock(folder);
  if (fresh) remove_study(folder);
  if (holds_study(folder)) require_same_study(folder, table);
  write_tables(folder, table);
  if (!limits.empty()) write_limits(folder, limits);
  replace_file(folder / kSummaryFile, summary);
}

}  // namespace consimd::studies
