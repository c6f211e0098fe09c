// The tables that end `consimd sweep`.
#pragma once

#include <string>
#include <vector>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/limits.hpp>

namespace consimd::cli {

/// A line per condition, outlier ratio and solver, units in the head. `wide`: of a study beyond the paper's, with the
/// condition before and the shares of outcomes behind.
[[nodiscard]] std::string sweep_table(const std::vector<studies::RatioSummary>& rows, bool wide);

/// A line per noise level, in ascending order. `points`: correspondences of a problem.
[[nodiscard]] std::string limit_table(std::vector<studies::LimitRecord> limits, std::size_t points);

}  // namespace consimd::cli
