// The table that ends `consimd sweep`.
#pragma once

#include <string>
#include <vector>

#include "study/cell_summary.hpp"

namespace consimd::cli {

/// A line per outlier ratio and solver, units in the head.
[[nodiscard]] std::string sweep_table(const std::vector<study::RatioSummary>& rows);

}  // namespace consimd::cli
