#include "compare/table_captions.hpp"

#include <map>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/studies/outside_solver.hpp>
#include <consimd/studies/success_limits.hpp>

namespace consimd::studies::detail {

std::string data_caption(const std::vector<const CaseGroup*>& groups) {
  std::vector<std::string> parts;
  parts.reserve(groups.size());
  for (const CaseGroup* group : groups) {
    parts.push_back(fmt::format("**{}** ({} case{}): {}", group->name, group->cases.size(),
                                group->cases.size() == 1 ? "" : "s", group->provenance));
  }
  return fmt::format("Data: {}.", fmt::join(parts, "; "));
}

std::string success_caption(const TableOptions& options, const std::vector<const CaseGroup*>& groups) {
  std::map<std::string, std::vector<std::string_view>> names;  // of groups, by their limits
  for (const CaseGroup* group : groups) {
    std::set<std::string> limits;
    for (const Case& tried : group->cases) {
      limits.insert(tried.displacement ? fmt::format("RMSE of the overlap's points at most {:g} m",
                                                     tried.displacement->root_mean_square)
                    : tried.limits     ? to_string(*tried.limits)
                                       : "RMSE of the true inliers below the noise bound");
    }
    names[fmt::format("{}", fmt::join(limits, " or "))].push_back(group->name);
  }
  std::vector<std::string> parts;
  parts.reserve(names.size());
  for (const auto& [limits, limited] : names) parts.push_back(fmt::format("{}: {}", fmt::join(limited, ", "), limits));
  return fmt::format("Success (thresholds `{}`): {}.", options.preset, fmt::join(parts, "; "));
}

std::string runs_caption(const Comparison& comparison) {
  std::string text =
      fmt::format("{} run{} per case, one at a time.", comparison.runs(), comparison.runs() == 1 ? "" : "s");
  if (!comparison.complete()) {
    text += fmt::format(" Unfinished: {} of {} runs.", comparison.filled(), comparison.size());
  }
  FailureCounts failures;
  for (const RunRecord& run : comparison.done()) failures.add(run.method, run.status);
  if (failures.any()) text += fmt::format(" Programs failed, which counts as no pose: {}.", failures.text());
  return text;
}

}  // namespace consimd::studies::detail
