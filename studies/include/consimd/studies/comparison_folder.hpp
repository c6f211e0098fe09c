// The files of a comparison, and how it is resumed.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/folder_lock.hpp>
#include <consimd/studies/paper_tables.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A value of an option as it is told: name and text.
using OptionText = std::pair<std::string, std::string>;

/// How a comparison was asked for and what it runs on.
struct ComparisonFacts {
  std::vector<OptionText> options;  ///< all that decide what is run; a folder is resumed only if they agree
  std::string_view isa;
  int threads = 1;
};

/// Where the folder of a comparison keeps the correspondences of scans: see `ScanOptions::cache`.
[[nodiscard]] std::filesystem::path correspondences_folder(const std::filesystem::path& folder);

/// The text of comparison.json.
[[nodiscard]] std::string comparison_json(const Comparison& comparison, const ComparisonFacts& facts);

/// The output folder of a comparison: comparison.json (what was run, on what data, by what, on what), runs.csv (a row a
/// run), tables.md and a CSV file a table, and of several methods pairs.csv, solvers.csv and curves.csv. That of a
/// shard has no tables: its groups lack cases. runs.csv grows by a whole line a run; a line that a crash cut short is
/// dropped on resuming. Functions throw std::runtime_error that names the file.
class ComparisonFolder {
 public:
  /// Opens or makes the folder, puts the runs of an earlier call into `comparison`, and gets ready to append. A folder
  /// that holds another comparison is an error that names the difference, unless `fresh`: then its files are removed.
  /// So is a folder that another process has open. Correspondences of scans, in `correspondences_folder`, go with it.
  ComparisonFolder(std::filesystem::path folder, Comparison& comparison, const ComparisonFacts& facts, bool fresh);

  void append(const RunRecord& record);

  /// Writes the tables, the sorted runs and the summary of a comparison, finished or not. Of a shard no tables.
  void write(const Comparison& comparison, const ComparisonResults& results, const ComparisonFacts& facts);

 private:
  void resume(Comparison& comparison, const ComparisonFacts& facts);
  void open_runs();

  std::filesystem::path folder_;
  std::optional<FolderLock> lock_;
  std::ofstream runs_;
};

}  // namespace studies
}  // namespace consimd
