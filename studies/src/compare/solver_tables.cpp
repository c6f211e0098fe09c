#include "compare/solver_tables.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/studies/run_statistics.hpp>

namespace consimd::studies::detail {
namespace {

using Pair = PairRow<GroupCell>;

/// "-0.4 (-0.5 .. -0.3)"
std::string with_interval(const Estimate& of, double factor) {
  if (std::isnan(of.value)) return "-";
  const auto digits = [&](double value) { return fmt::format("{:.3g}", factor * value); };
  return fmt::format("{} ({} .. {})", digits(of.value), digits(of.interval.low), digits(of.interval.high));
}

/// The groups in which one of the two alone beats the other, "mac in arch" where it is not the one of all groups.
std::string groups_that_differ(const MethodComparison& methods, const Pair& of) {
  std::vector<std::string> groups;
  for (const Pair& pair : methods.pairs) {
    if (pair.a != of.a || pair.b != of.b || pair.cell.group == kAllGroups || !differ(pair)) continue;
    const bool same = differ(of) && (pair.only_a > pair.only_b) == (of.only_a > of.only_b);
    groups.push_back(same ? pair.cell.group
                          : fmt::format("{} in {}", pair.only_a > pair.only_b ? pair.a : pair.b, pair.cell.group));
  }
  return groups.empty() ? "-" : fmt::format("{}", fmt::join(groups, "; "));
}

std::string quotient(double number) { return std::isfinite(number) ? fmt::format("{:.2f}", number) : "-"; }

std::string error(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-"; }

}  // namespace

TextTable pairs_table(const MethodComparison& methods, std::vector<std::string> caption) {
  caption.insert(
      caption.end(),
      {"Of all groups that ran both. A, B alone: cases that one alone solved (with several runs a case: in more of "
       "them). p: McNemar's exact test, two-sided, and adjusted by Holm for all rows; better: whose recall differs at "
       "0.05 then, and in which groups by itself.",
       "Differences are A less B with 95 % intervals of the paired bootstrap: recall of all cases, errors of the cases "
       "that both solved. Time: A over B, geometric mean."});
  TextTable table{
      .name = "pairs",
      .title = "Solvers on the same cases",
      .caption = std::move(caption),
      .columns = {"A", "B", "better", "in", "cases", "A alone", "B alone", "p", "p Holm", "recall difference %",
                  "rotation difference deg", "translation difference m", "time ratio"},
      .rows = {}};
  for (const Pair& pair : methods.pairs) {
    if (pair.cell.group != kAllGroups) continue;
    const std::string& better = pair.only_a > pair.only_b ? pair.a : pair.b;
    table.rows.push_back({pair.a, pair.b, differ(pair) ? better : "-", groups_that_differ(methods, pair),
                          fmt::format("{}", pair.trials), fmt::format("{}", pair.only_a),
                          fmt::format("{}", pair.only_b), fmt::format("{:.2g}", pair.p_value),
                          fmt::format("{:.2g}", pair.p_value_holm), with_interval(pair.recall, 100.0),
                          with_interval(pair.rotation_deg, 1.0), with_interval(pair.translation, 1.0),
                          with_interval(pair.time_ratio, 1.0)});
  }
  return table;
}

TextTable quantiles_table(const MethodComparison& methods, std::vector<std::string> caption) {
  caption.emplace_back(
      "Errors: 50 % and 90 % quantiles of all runs, a failure counting as infinite (-). Efficiency: mean square error "
      "of "
      "least squares on the true inliers over that of the solver, where it succeeded; 1 is as precise as can be. Time "
      "to "
      "a recall: within which so large a share of all runs succeeded.");
  TextTable table{.name = "quantiles",
                  .title = "Quantiles, efficiency and time to reach a recall",
                  .caption = std::move(caption),
                  .columns = {"data", "solver", "runs", "recall %", "95 % interval", "rotation deg 50 %",
                              "rotation deg 90 %", "translation m 50 %", "translation m 90 %", "rotation efficiency",
                              "translation efficiency", "ms to 50 %", "ms to 90 %", "ms to 99 %"},
                  .rows = {}};
  std::vector<std::string> groups;  // in their order, which `methods` has for each solver
  for (const SolverRow<GroupCell>& row : methods.solvers) {
    if (std::ranges::find(groups, row.cell.group) == groups.end()) groups.push_back(row.cell.group);
  }
  if (groups.size() == 2) groups.pop_back();  // all groups are the one
  for (const std::string& group : groups) {
    for (const SolverRow<GroupCell>& row : methods.solvers) {
      if (row.cell.group != group) continue;
      table.rows.push_back({group, row.solver, fmt::format("{}", row.trials), percent(row.recall),
                            interval(row.recall_interval), error(row.rotation_deg_median), error(row.rotation_deg_p90),
                            error(row.translation_median), error(row.translation_p90),
                            quotient(row.rotation_efficiency), quotient(row.translation_efficiency),
                            milliseconds(row.seconds_recall_50), milliseconds(row.seconds_recall_90),
                            milliseconds(row.seconds_recall_99)});
    }
  }
  return table;
}

}  // namespace consimd::studies::detail
