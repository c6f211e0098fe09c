// The methods of a comparison beside each other.
#pragma once

#include <string>
#include <tuple>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/comparison.hpp>
#include <consimd/studies/solver_comparison.hpp>
#include <consimd/studies/table_columns.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The cases of a group, or those of all groups.
struct GroupCell {
  std::string group;  ///< or `kAllGroups`

  /// Its column in a table of `Row`.
  template <typename Row>
  [[nodiscard]] static constexpr auto columns() {
    return std::tuple{Column{"group", member_of(&Row::cell, &GroupCell::group),
                             "group of cases; all groups: those of all groups that ran the solvers, together"}};
  }
};

using MethodComparison = SolverComparison<GroupCell>;

/// Made of the cases that all methods of a group have run with all seeds. A case counts once, with however many seeds:
/// the tests are of cases, which are independent, where runs on one of them are not. Stages that give no pose are left
/// out. Curves are of groups and of all of them. The random numbers of the bootstrap are always the same, so that the
/// same runs have the same intervals.
[[nodiscard]] MethodComparison compare_methods(const Comparison& comparison);

}  // namespace studies
}  // namespace consimd
