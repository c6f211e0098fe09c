// The files of a study, and how it is resumed.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/folder_lock.hpp>
#include <consimd/studies/limits.hpp>
#include <consimd/studies/study_summary.hpp>
#include <consimd/studies/trial_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

// Files of a study's folder.
inline constexpr std::string_view kTrialsFile = "trials.csv";
inline constexpr std::string_view kCellsFile = "cells.csv";
inline constexpr std::string_view kLimitsFile = "limits.csv";
inline constexpr std::string_view kSummaryFile = "summary.json";

/// The output folder of a study: trials.csv, cells.csv, summary.json, limits.csv if asked for, and pairs.csv,
/// solvers.csv and curves.csv of one that compares solvers. That of a shard has no cells.csv and none of the latter:
/// its cells lack trials.
///
/// While a study runs, trials.csv and limits.csv grow by a whole line a trial or noise level, in the order in which
/// these end; a line that a crash cut short is dropped on resuming. `finish` replaces trials.csv by the sorted table.
/// Functions throw std::runtime_error that names the file, and the line where there is one.
class StudyFolder {
 public:
  /// Opens or makes the folder, puts the trials of an earlier run into `table`, and gets ready to append. A folder that
  /// holds another study or shard is an error that names the difference, unless `fresh`: then the old study's files are
  /// removed. So is a folder that another process has open.
  StudyFolder(std::filesystem::path folder, TrialTable& table, const RunFacts& facts, bool fresh);

  void append(const TrialRecord& record);

  /// Writes the sorted trials.csv, summary.json and, unless it is that of a shard, cells.csv of a complete table, which
  /// need not keep records: all have been appended. Returns the summary of a study, an empty one of a shard.
  StudySummary finish(const TrialTable& table, RunFacts facts);

  /// The rows of limits.csv, those of earlier runs first.
  [[nodiscard]] const std::vector<LimitRecord>& limits() const noexcept { return limits_; }

  [[nodiscard]] bool has_limit(double sigma) const { return limit_levels_.contains(sigma); }

  /// Adds a row to the end of the file.
  void append(const LimitRecord& limit);

 private:
  void resume(TrialTable& table);
  /// Reads trials.csv and cuts it after its last whole line.
  void read_trials(TrialTable& table);
  void read_limits(const TrialTable& table);

  std::filesystem::path folder_;
  bool wide_;  ///< rows of a study beyond the paper's
  std::optional<FolderLock> lock_;
  std::ofstream trials_;
  std::ofstream limits_file_;
  std::vector<LimitRecord> limits_;
  std::set<double> limit_levels_;  ///< of those
};

/// Writes a finished study as if it had been run in `folder`, over what there is of the same study. Until all is
/// written summary.json says which study it is, and that it is not complete: after a crash the same call begins anew.
/// `limits`: in the order of the noise levels, none if they were not asked for. A folder that holds another study is an
/// error unless `fresh`, as above.
void write_study(const std::filesystem::path& folder, const TrialTable& table, const std::vector<LimitRecord>& limits,
                 std::string_view summary, bool fresh);

}  // namespace studies
}  // namespace consimd
