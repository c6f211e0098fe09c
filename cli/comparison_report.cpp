#include "comparison_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <consimd/studies/figures.hpp>

#include "figure_report.hpp"

namespace consimd::cli {

void print_comparison(const studies::ComparisonResults& results, const std::string& folder) {
  const bool compared = !results.methods.pairs.empty();
  for (const studies::TextTable& table : results.tables) fmt::print("\n{}", studies::to_markdown(table));
  fmt::print("\ndata: {0}/runs.csv, {0}/comparison.json, {0}/tables.md and a table_*.csv a table{1}\n", folder,
             compared ? fmt::format(", {0}/pairs.csv, {0}/solvers.csv, {0}/curves.csv", folder) : "");
  if (std::ranges::count(results.tables, "iterations", &studies::TextTable::name) != 0) {
    draw_and_name_figures(studies::kIterationsScript, folder, {"iterations"});
  }
  if (compared) draw_and_name_figures(studies::kComparisonScript, folder, {"comparison"});
}

}  // namespace consimd::cli
