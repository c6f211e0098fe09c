// A folder of one shard: what `consimd merge` reads. The input is its summary.json, trials.csv and limits.csv, each up
// to a byte 0.
#include <consimd/studies/shard_merge.hpp>
#include <consimd/studies/study_folder.hpp>

#include <algorithm>
#include <fstream>

#include "holds.hpp"
#include "process_folder.hpp"

namespace {

namespace fs = std::filesystem;
using namespace consimd;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path folder = fuzz::make_process_folder();
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  for (const std::string_view name : {studies::kSummaryFile, studies::kTrialsFile, studies::kLimitsFile}) {
    const std::string_view text = rest.substr(0, rest.find('\0'));
    rest.remove_prefix(std::min(rest.size(), text.size() + 1));
    std::ofstream(folder / name, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  fuzz::may_refuse([&] {
    const studies::MergedStudy merged = studies::merge_shards(studies::shard_folders({folder}), false);
    fuzz::require(merged.table.complete(), "a complete study or an error");
  });
  return 0;
}
