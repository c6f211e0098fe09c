#include "sweep/trial_sorting.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <consimd/synth/pending_file.hpp>

#include "files/csv_file.hpp"

namespace consimd::studies {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostFiles = 256;  // that are open at a time
constexpr std::size_t kBuffer = std::size_t{1} << 16U;

using Take = std::function<void(const TrialRecord&)>;

/// Rows on their way to a file that is gone at the end.
class RowFile {
 public:
  RowFile(const fs::path& beside, const std::string& header) : file_(beside, header + "\n") {}

  void add(std::string_view row) {
    buffer_.append(row).push_back('\n');
    if (buffer_.size() >= kBuffer) flush();
  }

  /// Where the rows are.
  const fs::path& path() {
    flush();
    return file_.temporary();
  }

 private:
  void flush() {
    file_.append(buffer_);
    buffer_.clear();
  }

  synth::PendingFile file_;
  std::string buffer_;
};

void sort_in_memory(const fs::path& path, const TrialTable& table, const Take& take) {
  std::vector<std::pair<std::size_t, TrialRecord>> records;
  for_each_whole_row(path, trial_header(table.wide()), [&](std::string_view line) {
    TrialRecord record = parse_trial_row(line, table.wide());
    const std::size_t slot = table.slot_of(record);
    records.emplace_back(slot, std::move(record));
  });
  // The first of two records of a trial counts, as in a table.
  std::ranges::stable_sort(records, {}, [](const auto& record) { return record.first; });
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (i == 0 || records[i].first != records[i - 1].first) take(records[i].second);
  }
}

}  // namespace

void for_each_sorted(const fs::path& trials, const TrialTable& table, const Take& take, std::size_t rows_in_memory) {
  const std::size_t wanted = (table.size() + rows_in_memory - 1) / rows_in_memory;
  if (wanted <= 1) return sort_in_memory(trials, table, take);
  const std::size_t count = std::min(wanted, kMostFiles);
  const std::size_t share = (table.slots() + count - 1) / count;  // slots of a file
  std::vector<std::unique_ptr<RowFile>> files;
  files.reserve(count);
  const std::string header = trial_header(table.wide());
  for (std::size_t i = 0; i < count; ++i) files.push_back(std::make_unique<RowFile>(trials, header));
  for_each_whole_row(trials, header, [&](std::string_view line) {
    files[table.slot_of(parse_trial_row(line, table.wide())) / share]->add(line);
  });
  for (std::unique_ptr<RowFile>& file : files) {
    sort_in_memory(file->path(), table, take);
    file.reset();
  }
}

}  // namespace consimd::studies
