#include <consimd/studies/trial_record.hpp>

#include "files/csv_rows.hpp"

namespace consimd::studies {

std::string to_csv_row(const TrialRecord& record) { return csv_row(kTrialColumns, record); }

TrialRecord parse_trial_row(std::string_view line) { return parse_csv_row<TrialRecord>(kTrialColumns, line); }

}  // namespace consimd::studies
