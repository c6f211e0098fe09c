#include <consimd/studies/method_comparison.hpp>

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include <consimd/studies/method.hpp>
#include "statistics/compare_strata.hpp"

namespace consimd::studies {
namespace {

constexpr std::uint64_t kSeed = 1;  // of the bootstrap

detail::ComparedRun run_of(const RunRecord& record) {
  return {.success = record.success,
          .limit_ratio = record.has_pose() ? record.limit_ratio : std::numeric_limits<double>::infinity(),
          .rotation_error_deg = record.rotation_error_deg,
          .translation_error = record.translation_error,
          .oracle_rotation_error_deg = record.oracle_rotation_error_deg,
          .oracle_translation_error = record.oracle_translation_error,
          .seconds = record.seconds};
}

/// The runs of a group's methods on the cases that all of them have run on with all seeds.
detail::Stratum<GroupCell> stratum_of(const Comparison& comparison, const CaseGroup& group) {
  detail::Stratum<GroupCell> stratum{
      .cell = {group.name}, .pool = 0, .runs_per_problem = comparison.runs(), .solvers = {}};
  std::vector<std::vector<RunRecord>> runs;
  std::map<std::string, std::size_t, std::less<>> done;  // runs by case
  for (const std::string& method : group.methods) {
    if (gives_rows_alone(method)) continue;
    stratum.solvers.push_back({method, {}});
    runs.push_back(comparison.runs_of(group.name, method));
    for (const RunRecord& run : runs.back()) ++done[run.case_name];
  }
  const std::size_t all = runs.size() * comparison.runs();
  for (std::size_t m = 0; m < runs.size(); ++m) {
    for (const RunRecord& run : runs[m]) {
      if (done.find(run.case_name)->second == all) stratum.solvers[m].runs.push_back(run_of(run));
    }
  }
  if (!runs.empty() && stratum.solvers.front().runs.empty()) stratum.solvers.clear();
  return stratum;
}

}  // namespace

MethodComparison compare_methods(const Comparison& comparison) {
  std::vector<detail::Stratum<GroupCell>> strata;
  for (const CaseGroup& group : comparison.groups()) strata.push_back(stratum_of(comparison, group));
  return detail::compare_strata(strata, {GroupCell{std::string(kAllGroups)}}, kSeed, true);
}

}  // namespace consimd::studies
