// The tables of solvers beside each other.
#pragma once

#include <string>
#include <vector>

#include <consimd/studies/method_comparison.hpp>
#include <consimd/studies/text_table.hpp>

namespace consimd::studies::detail {

/// A row per pair, of all groups that ran both. `caption`: of the data, of success and runs; more is added.
[[nodiscard]] TextTable pairs_table(const MethodComparison& methods, std::vector<std::string> caption);

/// A row per group and method, then those of all groups where there are several.
[[nodiscard]] TextTable quantiles_table(const MethodComparison& methods, std::vector<std::string> caption);

}  // namespace consimd::studies::detail
