// How a study that is complete is shown.
#pragma once

#include <string>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/limits.hpp>

namespace consimd::cli {

/// Prints the table of a whole study.
void print_trials(const studies::StudySummary& summary);

/// Prints where the limits lie.
void print_limits(const std::vector<studies::LimitRecord>& limits, const studies::SweepOptions& options);

/// Names the files of the study in `folder` and draws its figures. A figure that cannot be drawn is told, no error.
/// `map`: with limits.
void print_files_and_draw(const std::string& folder, bool map);

}  // namespace consimd::cli
