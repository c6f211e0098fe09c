// Rows of trials.csv, runs.csv and limits.csv, as resuming reads them.
#include <consimd/studies/limits.hpp>
#include <consimd/studies/run_record.hpp>
#include <consimd/studies/trial_record.hpp>

#include "files/csv_file.hpp"
#include "holds.hpp"

namespace {

using namespace consimd;

/// What was read is written so that it reads back the same.
template <typename Parse>
void read_row(std::string_view line, const Parse& parse) {
  fuzz::may_refuse([&] {
    std::string row = studies::to_csv_row(parse(line));
    row.pop_back();
    fuzz::require(studies::to_csv_row(parse(row)) == row + "\n", "rows that read back the same");
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::may_refuse([&] {
    studies::for_each_row("table", text, text.substr(0, text.find('\n')), [](std::string_view line) {
      read_row(line, [](std::string_view row) { return studies::parse_trial_row(row); });
      read_row(line, [](std::string_view row) { return studies::parse_run_row(row); });
      read_row(line, [](std::string_view row) { return studies::parse_limit_row(row); });
    });
  });
  return 0;
}
