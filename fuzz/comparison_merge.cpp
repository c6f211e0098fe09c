// A folder of one shard of a comparison: what `consimd merge` reads. The input is its comparison.json and runs.csv,
// each up to a byte 0.
#include <consimd/studies/comparison_merge.hpp>

#include <algorithm>
#include <fstream>
#include <string_view>

#include "holds.hpp"
#include "process_folder.hpp"

namespace {

namespace fs = std::filesystem;
using namespace consimd;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fs::path folder = fuzz::make_process_folder();
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  for (const char* name : {"comparison.json", "runs.csv"}) {
    const std::string_view text = rest.substr(0, rest.find('\0'));
    rest.remove_prefix(std::min(rest.size(), text.size() + 1));
    std::ofstream(folder / name, std::ios::binary).write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  fuzz::may_refuse([&] {
    const std::vector<fs::path> shards = studies::comparison_shards({folder});
    if (shards.empty()) return;
    const studies::MergedComparison merged = studies::merge_comparisons(shards);
    fuzz::require(merged.comparison.complete(), "a complete comparison or an error");
    const studies::ComparisonResults results = studies::comparison_results(merged.tables, merged.comparison);
    for (const studies::TextTable& table : results.tables) {
      for (const auto& row : table.rows) fuzz::require(row.size() == table.columns.size(), "as many cells as columns");
    }
  });
  return 0;
}
