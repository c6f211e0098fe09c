#include <consimd/studies/study_folder.hpp>

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <consimd/synth/pending_file.hpp>
#include <consimd/synth/text_file.hpp>

#include <consimd/studies/replace_file.hpp>
#include "files/csv_file.hpp"
#include "statistics/comparison_files.hpp"
#include "sweep/trial_sorting.hpp"

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
  for (const std::string_view name : detail::kSolverComparisonFiles) fs::remove(folder / name);
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
    other = difference(synth::read_text(folder / kSummaryFile), table);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}; {}", (folder / kSummaryFile).string(), error.what(), kRemedy));
  }
  if (!other.empty()) {
    throw std::runtime_error(fmt::format("{} holds another study: {}; {}", folder.string(), other, kRemedy));
  }
}

/// Writes trials.csv and, unless it is that of a shard, cells.csv of what `for_each(take)` gives in order.
template <typename ForEach>
StudySummary write_tables(const fs::path& folder, const TrialTable& table, const ForEach& for_each) {
  constexpr std::size_t kBuffer = std::size_t{1} << 20U;
  StudySummary summary(table.options());
  synth::PendingFile file(folder / kTrialsFile, trial_header(table.wide()) + "\n");
  std::string rows;
  for_each([&](const TrialRecord& record) {
    rows += to_csv_row(record, table.wide());
    if (rows.size() >= kBuffer) file.append(std::exchange(rows, {}));
    if (!table.shard()) summary.add(record);
  });
  file.append(rows);
  file.commit();

  if (table.shard()) return summary;
  std::string cells = cell_header(table.wide()) + "\n";
  for (const CellSummary& cell : summary.cells()) cells += to_csv_row(cell, table.wide());
  replace_file(folder / kCellsFile, cells);
  if (const std::optional<TrialComparison> comparison = summary.comparison()) {
    detail::write_solver_comparison(folder, *comparison);
  }
  return summary;
}

void append_row(std::ofstream& file, const std::string& row, const fs::path& path) {
  file << row << std::flush;
  if (!file) throw std::runtime_error(fmt::format("{}: cannot write", path.string()));
}

void write_limits(const fs::path& folder, const std::vector<LimitRecord>& limits) {
  std::string text = csv_header(kLimitColumns) + "\n";
  for (const LimitRecord& row : limits) text += to_csv_row(row);
  replace_file(folder / kLimitsFile, text);
}

}  // namespace

StudyFolder::StudyFolder(fs::path folder, TrialTable& table, const RunFacts& facts, bool fresh)
    : folder_(std::move(folder)), wide_(table.wide()) {
  require_writable_folder(folder_);
  lock_.emplace(folder_);
  if (fresh) remove_study(folder_);
  if (holds_study(folder_)) resume(table);

  replace_file(folder_ / kSummaryFile, summary_json(table, facts));
  if (table.filled() == 0) replace_file(folder_ / kTrialsFile, trial_header(table.wide()) + "\n");
  trials_.open(folder_ / kTrialsFile, std::ios::binary | std::ios::app);
}

void StudyFolder::resume(TrialTable& table) {
  require_same_study(folder_, table);
  if (fs::exists(folder_ / kTrialsFile)) read_trials(table);
  if (fs::exists(folder_ / kLimitsFile)) read_limits(table);
}

void StudyFolder::read_trials(TrialTable& table) {
  for_each_whole_row(folder_ / kTrialsFile, trial_header(table.wide()),
                     [&](std::string_view line) { table.put(parse_trial_row(line, table.wide())); });
}

void StudyFolder::append(const TrialRecord& record) {
  append_row(trials_, to_csv_row(record, wide_), folder_ / kTrialsFile);
}

StudySummary StudyFolder::finish(const TrialTable& table, RunFacts facts) {
  trials_.close();
  StudySummary summary =
      write_tables(folder_, table, [&](const auto& take) { for_each_sorted(folder_ / kTrialsFile, table, take); });
  facts.complete = true;
  replace_file(folder_ / kSummaryFile, summary_json(table, facts));
  return summary;
}

void StudyFolder::read_limits(const TrialTable& table) {
  const fs::path path = folder_ / kLimitsFile;
  const std::vector<double> of_study = limit_levels(table.options(), table.shard());
  const std::set<double> levels(of_study.begin(), of_study.end());
  for_each_whole_row(path, csv_header(kLimitColumns), [&](std::string_view line) {
    const LimitRecord limit = parse_limit_row(line);
    if (limit.problems != kLimitProblems || !levels.contains(limit.sigma) ||
        !limit_levels_.insert(limit.sigma).second) {
      throw std::invalid_argument(
          fmt::format("noise level {} with {} problems is not of this study", limit.sigma, limit.problems));
    }
    limits_.push_back(limit);
  });
}

void StudyFolder::append(const LimitRecord& limit) {
  if (limits_.empty()) write_limits(folder_, {});
  if (!limits_file_.is_open()) limits_file_.open(folder_ / kLimitsFile, std::ios::binary | std::ios::app);
  limits_.push_back(limit);
  limit_levels_.insert(limit.sigma);
  append_row(limits_file_, to_csv_row(limit), folder_ / kLimitsFile);
}

void write_study(const fs::path& folder, const TrialTable& table, const std::vector<LimitRecord>& limits,
                 std::string_view summary, bool fresh) {
  require_writable_folder(folder);
  const FolderLock lock(folder);
  if (fresh) remove_study(folder);
  if (holds_study(folder)) require_same_study(folder, table);
  // A table without a summary is nobody's study: whoever is stopped on the way leaves one that can be taken up.
  replace_file(folder / kSummaryFile, unfinished_summary(summary));
  write_tables(folder, table, [&](const auto& take) { table.for_each(take); });
  if (!limits.empty()) write_limits(folder, limits);
  replace_file(folder / kSummaryFile, summary);
}

}  // namespace consimd::studies
