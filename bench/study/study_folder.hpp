// The files of a study, and how it is resumed.
#pragma once

#include <filesystem>
#include <fstream>
#include <vector>

#include "study/limits.hpp"
#include "study/study_summary.hpp"
#include "study/trial_table.hpp"

namespace consimd::study {

/// The output folder of a study: trials.csv, cells.csv, summary.json, and limits.csv if asked for.
///
/// While a study runs, trials.csv grows by a whole line a trial, in the order in which trials end; a line that a crash
/// cut short is dropped on resuming. `finish` replaces it by the sorted table. Functions throw std::runtime_error that
/// names the file.
class StudyFolder {
 public:
  /// Opens or makes the folder, puts the trials of an earlier run into `table`, and gets ready to append. A folder that
  /// holds another study is an error that names the difference, unless `fresh`: then the old study's files are removed.
  StudyFolder(std::filesystem::path folder, TrialTable& table, const RunFacts& facts, bool fresh);

  void append(const TrialRecord& record);

  /// Writes the sorted trials.csv, cells.csv and summary.json of a complete table.
  void finish(const TrialTable& table, RunFacts facts);

  /// The rows of limits.csv, those of earlier runs first.
  [[nodiscard]] const std::vector<LimitRecord>& limits() const noexcept { return limits_; }

  /// Adds a row and writes the file.
  void append(const LimitRecord& limit);

 private:
  void remove_study();
  void resume(TrialTable& table);
  /// Reads trials.csv and cuts it after its last whole line.
  void read_trials(TrialTable& table);
  void read_limits(const SweepOptions& options);

  std::filesystem::path folder_;
  std::ofstream trials_;
  std::vector<LimitRecord> limits_;
};

}  // namespace consimd::study
