#include <consimd/studies/run_record.hpp>

#include "files/csv_rows.hpp"

namespace consimd::studies {

std::string to_csv_row(const RunRecord& record) { return csv_row(kRunColumns, record); }

RunRecord parse_run_row(std::string_view line) { return parse_csv_row<RunRecord>(kRunColumns, line); }

}  // namespace consimd::studies
