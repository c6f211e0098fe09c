#include "comparison_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <consimd/studies/figures.hpp>

#include "figure_report.hpp"

namespace consimd::cli {

void print_comparison(const std::vector<studies::TextTable>& tables, const std::string& folder) {
  for (const studies::TextTable& table : tables) fmt::print("\n{}", studies::to_markdown(table));
  fmt::print("\ndata: {0}/runs.csv, {0}/comparison.json, {0}/tables.md and a table_*.csv a table\n", folder);
  if (std::ranges::count(tables, "iterations", &studies::TextTable::name) != 0) {
    draw_and_name_figures(studies::kIterationsScript, folder, {"iterations"});
  }
}

}  // namespace consimd::cli
