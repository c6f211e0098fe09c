// Which tables a comparison makes, and of what.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/outside_solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct TableInfo {
  std::string_view name;
  std::string_view description;
};

/// "data", "solvers", "pairs", "quantiles", "pipeline", "boost", "stages", "poses", "iterations" and "scales".
[[nodiscard]] std::span<const TableInfo> paper_tables() noexcept;

/// What is to be run and told.
struct TableOptions {
  std::vector<std::string> tables;  ///< names of paper_tables()
  /// Those that "solvers", "pairs", "quantiles", "pipeline" and "boost" run, as SolverChoice takes them, or outside
  /// ones.
  std::vector<std::string> solvers;
  OutsideSolvers outside = {};            ///< those that `solvers` names
  bool filtered = false;                  ///< "solvers", "pairs" and "quantiles" after TCF's filter
  std::string preset = "case";            ///< of success limits, told in captions
  std::vector<std::uint32_t> iterations;  ///< of "iterations"
  std::vector<double> scales;             ///< of "scales"
};

/// Throws std::invalid_argument on an unknown, missing or repeated name or value, if "scales" is wanted of solvers none
/// of which finds the scale, and if "pairs" alone is wanted of one solver.
void validate(const TableOptions& options);

}  // namespace studies
}  // namespace consimd
