// A study that takes milliseconds.
#pragma once

#include <consimd/studies/sweep.hpp>

namespace consimd::studies {

inline SweepOptions small_study() {
  SweepOptions options;
  options.points = {200};
  options.outlier_ratios = {0.5, 0.8};
  options.sigmas = {0.1, 1.0};
  options.trials = 3;
  options.seed = 5;
  return options;
}

/// The records with their times set to zero.
inline std::vector<TrialRecord> timeless(const TrialTable& table) {
  std::vector<TrialRecord> records(table.records().begin(), table.records().end());
  for (TrialRecord& record : records) record.seconds = 0.0;
  return records;
}

}  // namespace consimd::studies
