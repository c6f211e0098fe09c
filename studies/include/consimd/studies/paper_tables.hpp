// The tables of the TCF paper's evaluation, from the runs of a comparison.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/outside_solver.hpp>
#include <consimd/studies/text_table.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

struct TableInfo {
  std::string_view name;
  std::string_view description;
};

/// "data", "solvers", "pipeline", "boost", "stages", "poses", "iterations" and "scales".
[[nodiscard]] std::span<const TableInfo> paper_tables() noexcept;

/// What is to be run and told.
struct TableOptions {
  std::vector<std::string> tables;   ///< names of paper_tables()
  std::vector<std::string> solvers;  ///< of "solvers", "pipeline", "boost", as SolverChoice takes them, or outside ones
  OutsideSolvers outside = {};       ///< those that `solvers` names
  bool filtered = false;             ///< "solvers" after TCF's filter
  std::string preset = "case";       ///< of success limits, told in captions
  std::vector<std::uint32_t> iterations;  ///< of "iterations"
  std::vector<double> scales;             ///< of "scales"
};

/// Throws std::invalid_argument on an unknown, missing or repeated name or value, and if "scales" is wanted of solvers
/// none of which finds the scale.
void validate(const TableOptions& options);

/// The methods that the tables but "iterations" and "scales" need on a group of cases; those that "pipeline" needs as
/// well where there are scans, of consimd's own solvers; those that the other two need.
[[nodiscard]] std::vector<std::string> methods_of(const TableOptions& options);
[[nodiscard]] std::vector<std::string> scan_methods(const TableOptions& options);
[[nodiscard]] std::vector<std::string> iteration_methods(const TableOptions& options);
[[nodiscard]] std::vector<std::string> scale_methods(const TableOptions& options);

/// The cases of "iterations": `problems` problems of the noise study with 2 % inliers and noise of 1 m.
[[nodiscard]] CaseGroup iteration_group(const TableOptions& options, std::uint32_t problems, std::uint64_t seed);

/// The cases of "scales", a group a scale: `trials` problems at each noise level of the noise study with 90 % outliers.
/// None if the table is not wanted.
[[nodiscard]] std::vector<CaseGroup> scale_groups(const TableOptions& options, std::uint32_t trials,
                                                  std::uint64_t seed);

/// The tables, in the order of paper_tables(). Runs that are missing are left out.
[[nodiscard]] std::vector<TextTable> make_tables(const TableOptions& options, const Comparison& comparison);

}  // namespace studies
}  // namespace consimd
