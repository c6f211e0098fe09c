// summary.json: what was run, by what, on what.
#pragma once

#include <string>
#include <string_view>

#include "study/sweep_options.hpp"

namespace consimd::study {

/// How far a study has come and what it runs on.
struct RunFacts {
  std::string_view isa;
  int threads = 1;
  std::size_t trials_done = 0;  ///< rows of trials.csv
  bool complete = false;
};

/// The text of summary.json.
[[nodiscard]] std::string summary_json(const SweepOptions& options, const RunFacts& facts);

/// Compares the study that `summary` (a text of `summary_json`) describes with `options` and this build. Empty when
/// trials of the two may stand in one table, else the first difference, as "it has trials 100, not 50". Throws
/// std::invalid_argument if the text is no summary.
[[nodiscard]] std::string difference(std::string_view summary, const SweepOptions& options);

}  // namespace consimd::study
