// The files of solvers beside each other.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/solver_comparison.hpp>
#include "files/csv_rows.hpp"

namespace consimd::studies::detail {

/// All of them, the figure's among them.
inline constexpr std::array<std::string_view, 5> kSolverComparisonFiles{kPairsFile, kSolversFile, kCurvesFile,
                                                                        "comparison.svg", "comparison.png"};

/// Header and rows.
template <typename Columns, typename Row>
[[nodiscard]] std::string table_text(const Columns& columns, const std::vector<Row>& rows) {
  std::string text = csv_header(columns) + "\n";
  for (const Row& row : rows) text += csv_row(columns, row);
  return text;
}

/// Writes the tables to `folder`. Throws std::runtime_error that names the file.
template <typename Cell>
void write_solver_comparison(const std::filesystem::path& folder, const SolverComparison<Cell>& comparison) {
  replace_file(folder / kPairsFile, table_text(kPairColumns<Cell>, comparison.pairs));
  replace_file(folder / kSolversFile, table_text(kSolverColumns<Cell>, comparison.solvers));
  replace_file(folder / kCurvesFile, table_text(kCurveColumns<Cell>, comparison.curves));
}

}  // namespace consimd::studies::detail
