// What has to be run for the tables of a comparison.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/case_group.hpp>
#include <consimd/studies/table_options.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

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

}  // namespace studies
}  // namespace consimd
