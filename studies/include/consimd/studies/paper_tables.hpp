// The tables of the TCF paper's evaluation, and those of solvers beside each other, from the runs of a comparison.
#pragma once

#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/method_comparison.hpp>
#include <consimd/studies/table_options.hpp>
#include <consimd/studies/text_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What a comparison tells: the tables that people read, and its methods beside each other.
struct ComparisonResults {
  std::vector<TextTable> tables = {};
  MethodComparison methods = {};
};

/// The tables in the order of paper_tables(); runs that are missing are left out. A table of solvers beside each other
/// is left out where no solver has a run.
[[nodiscard]] ComparisonResults comparison_results(const TableOptions& options, const Comparison& comparison);

}  // namespace studies
}  // namespace consimd
