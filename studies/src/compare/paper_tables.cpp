#include <consimd/studies/paper_tables.hpp>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include <consimd/kernels/elementary_functions.hpp>

#include <consimd/studies/method.hpp>
#include <consimd/studies/run_statistics.hpp>
#include "compare/solver_tables.hpp"
#include "compare/table_captions.hpp"
#include "compare/table_methods.hpp"

namespace consimd::studies {
using namespace detail;
namespace {

constexpr std::string_view kErrorsCaption =
    "Errors: mean over the successes, as in the paper, and in brackets the median over all runs, failures included.";
constexpr std::string_view kTimeCaption = "Time: median of the whole registration.";

class TableMaker {
 public:
  TableMaker(const TableOptions& options, const Comparison& comparison, const MethodComparison& methods)
      : options_(options), comparison_(comparison), methods_(methods) {
    std::set<std::string> scales;
    for (const double scale : options.scales) scales.insert(scale_group_name(scale));
    for (const CaseGroup& group : comparison.groups()) {
      if (scales.contains(group.name)) {
        scale_groups_.push_back(&group);
      } else if (group.name != kIterationGroup) {
        groups_.push_back(&group);
      }
    }
  }

  /// None of what would have no rows.
  [[nodiscard]] std::optional<TextTable> make(std::string_view name) const {
    if (name == "pairs") return filled(pairs_table(methods_, captions_of_all()));
    if (name == "quantiles") return filled(quantiles_table(methods_, captions_of_all()));
    if (name == "data") return data();
    if (name == "solvers") return solvers();
    if (name == "pipeline") return pipeline();
    if (name == "boost") return boost();
    if (name == "stages") return stages();
    if (name == "poses") return poses();
    if (name == "scales") return scales();
    return iterations();
  }

 private:
  static std::optional<TextTable> filled(TextTable table) {
    return table.rows.empty() ? std::nullopt : std::optional(std::move(table));
  }

  [[nodiscard]] std::vector<std::string> captions_of_all() const {
    std::vector<const CaseGroup*> all;
    for (const CaseGroup& group : comparison_.groups()) all.push_back(&group);
    return {data_caption(all), success_caption(options_, all), runs_caption(comparison_)};
  }

  /// Statistics of a method on a group; none if nothing is done yet.
  [[nodiscard]] RunStatistics statistics_of(const CaseGroup& group, std::string_view method) const {
    return run_statistics(comparison_.runs_of(group.name, method));
  }

  [[nodiscard]] std::vector<std::string> captions(std::initializer_list<std::string_view> more) const {
    std::vector<std::string> caption{data_caption(groups_), success_caption(options_, groups_),
                                     runs_caption(comparison_)};
    caption.insert(caption.end(), more.begin(), more.end());
    return caption;
  }

  [[nodiscard]] TextTable data() const {
    TextTable table{.name = "data",
                    .title = "Data",
                    .caption = {data_caption(groups_), runs_caption(comparison_),
                                "Distance: between the scans of a case, mean. |C| and inliers: means of "
                                "correspondences, and of the share of them within the noise bound of the true pose."},
                    .columns = {"data", "cases", "distance m", "|C|", "inliers %"},
                    .rows = {}};
    for (const CaseGroup* group : groups_) {
      double distance = 0.0;
      for (const Case& tried : group->cases) distance += tried.distance / static_cast<double>(group->cases.size());
      const RunStatistics s = statistics_of(*group, kInputStage);
      table.rows.push_back({group->name, fmt::format("{}", group->cases.size()), metres(distance), count(s.rows),
                            percent(s.inlier_ratio)});
    }
    return table;
  }

  [[nodiscard]] TextTable pipeline() const {
    TextTable table{
        .name = "pipeline",
        .title = "From scans to a verified pose",
        .caption = captions({"The whole pipeline on the points: voxels, features, matches, solver, and the decision of "
                             "the scans over its pose; as `consimd register SOURCE TARGET`.",
                             "Wrong: poses that are called a success and are outside of the limits.", kErrorsCaption,
                             "Time: median of all of it, from points in memory."}),
        .columns = {"data", "solver", "recall %", "95 % interval", "wrong %", "rotation error deg",
                    "translation error m", "time ms"},
        .rows = {}};
    for (const CaseGroup* group : groups_) {
      for (const std::string& method : group->methods) {
        const std::optional<std::string_view> solver = pipeline_solver(method);
        if (!solver) continue;
        const RunStatistics s = statistics_of(*group, method);
        table.rows.push_back({group->name, std::string(*solver), percent(s.recall), interval(s.recall_interval),
                              percent(s.wrong), error(s.rotation_deg), error(s.translation),
                              milliseconds(s.seconds_median)});
      }
    }
    return table;
  }

  [[nodiscard]] TextTable solvers() const {
    TextTable table{
        .name = "solvers",
        .title = options_.filtered ? "Recall, errors and time after TCF's filter" : "Recall, errors and time",
        .caption = captions({kErrorsCaption, kTimeCaption}),
        .columns = {"data", "solver", "recall %", "95 % interval", "rotation error deg", "translation error m",
                    "time ms"},
        .rows = {}};
    for (const CaseGroup* group : groups_) {
      for (const std::string& solver : options_.solvers) {
        const RunStatistics s = statistics_of(*group, options_.filtered ? after_filter(solver) : solver);
        table.rows.push_back({group->name, solver, percent(s.recall), interval(s.recall_interval),
                              error(s.rotation_deg), error(s.translation), milliseconds(s.seconds_median)});
      }
    }
    return table;
  }

  [[nodiscard]] TextTable boost() const {
    TextTable table{
        .name = "boost",
        .title = "Each solver alone and after TCF's filter",
        .caption = captions({kErrorsCaption,
                             "Time: median of the whole registration, the filter included. |C| and inliers: "
                             "means of what the solver is given."}),
        .columns = {"data", "solver", "|C|", "inliers %", "recall %", "rotation error deg", "translation error m",
                    "time ms"},
        .rows = {}};
    for (const CaseGroup* group : groups_) {
      const RunStatistics kept = statistics_of(*group, kFilterStages);
      for (const std::string& solver : options_.solvers) {
        const RunStatistics alone = statistics_of(*group, solver), after = statistics_of(*group, after_filter(solver));
        table.rows.push_back({group->name, solver, count(kept.rows), percent(kept.inlier_ratio), percent(alone.recall),
                              error(alone.rotation_deg), error(alone.translation), milliseconds(alone.seconds_median)});
        table.rows.push_back({group->name, after_filter(solver), count(kept.kept), percent(kept.kept_inlier_ratio),
                              percent(after.recall), error(after.rotation_deg), error(after.translation),
                              milliseconds(after.seconds_median)});
      }
    }
    return table;
  }

  [[nodiscard]] TextTable stages() const {
    TextTable table{
        .name = "stages",
        .title = "Outlier removal by the stages of TCF",
        .caption = {data_caption(groups_), runs_caption(comparison_),
                    "1R, 2R, 3R: one-, two- and three-point RANSAC with their defaults, each on what the one "
                    "before kept. Inlier ratio (IR) and number of inliers (IN): means of what is left; of an "
                    "empty set the ratio is 0. Time: median of the stages together."},
        .columns = {"data", "stages", "IR %", "IN", "rows left", "time ms"},
        .rows = {}};
    for (const CaseGroup* group : groups_) {
      const RunStatistics input = statistics_of(*group, kStages.front());
      table.rows.push_back(
          {group->name, "none", percent(input.inlier_ratio), count(input.inliers), count(input.rows), "-"});
      for (const char* method : kStages) {
        const RunStatistics s = statistics_of(*group, method);
        table.rows.push_back({group->name, method, percent(s.kept_inlier_ratio), count(s.kept_inliers), count(s.kept),
                              milliseconds(s.seconds_median)});
      }
    }
    return table;
  }

  [[nodiscard]] TextTable poses() const {
    TextTable table{.name = "poses",
                    .title = "3R against IRLS against both",
                    .caption = captions({"After 1R+2R the pose is that of three-point RANSAC, of the scale-adaptive "
                                         "IRLS, or of the IRLS on what 3R kept. No re-selection among all rows, no "
                                         "test of significance.",
                                         kErrorsCaption, "Time: median of all stages."}),
                    .columns = {"data", "stages", "recall %", "95 % interval", "rotation error deg",
                                "translation error m", "time ms"},
                    .rows = {}};
    for (const CaseGroup* group : groups_) {
      for (const char* method : kPoses) {
        const RunStatistics s = statistics_of(*group, method);
        table.rows.push_back({group->name, method, percent(s.recall), interval(s.recall_interval),
                              error(s.rotation_deg), error(s.translation), milliseconds(s.seconds_median)});
      }
    }
    return table;
  }

  [[nodiscard]] TextTable iterations() const {
    const auto group = std::ranges::find(comparison_.groups(), kIterationGroup, &CaseGroup::name);
    TextTable table{
        .name = "iterations",
        .title = "Recall of plain RANSAC over its iterations at 2 % inliers",
        .caption =
            {data_caption({&*group}), success_caption(options_, {&*group}), runs_caption(comparison_),
             "Plain: fixed number of samples, no local optimisation; the pose is refined and tested like others.",
             "Expected: the chance that a sample is all inliers. tcf: the default solver on the same problems.",
             std::string(kTimeCaption)},
        .columns = {"solver", "iterations", "recall %", "95 % interval", "expected %", "time ms"},
        .rows = {}};
    const double share = (1.0 - kIterationOutliers) * (1.0 - kIterationOutliers) * (1.0 - kIterationOutliers);
    for (const std::uint32_t n : options_.iterations) {
      const RunStatistics s = statistics_of(*group, plain_ransac(n));
      table.rows.push_back({"plain ransac", fmt::format("{}", n), percent(s.recall), interval(s.recall_interval),
                            percent(-elementary::expm1(n * elementary::log1p(-share))),
                            milliseconds(s.seconds_median)});
    }
    const RunStatistics rival = statistics_of(*group, kIterationRival);
    table.rows.push_back({std::string(kIterationRival), "-", percent(rival.recall), interval(rival.recall_interval),
                          "-", milliseconds(rival.seconds_median)});
    return table;
  }

  [[nodiscard]] TextTable scales() const {
    TextTable table{
        .name = "scales",
        .title = "Unknown scale of the source",
        .caption = {data_caption(scale_groups_), success_caption(options_, scale_groups_), runs_caption(comparison_),
                    "Scale error: relative, the largest of all runs with a pose.", std::string(kErrorsCaption),
                    std::string(kTimeCaption)},
        .columns = {"data", "solver", "recall %", "95 % interval", "largest scale error %", "rotation error deg",
                    "translation error m", "time ms"},
        .rows = {}};
    for (const CaseGroup* group : scale_groups_) {
      for (const std::string& solver : options_.solvers) {
        if (!finds_scale(options_, solver)) continue;
        const RunStatistics s = statistics_of(*group, with_scale(solver));
        table.rows.push_back({group->name, solver, percent(s.recall), interval(s.recall_interval),
                              fine_percent(s.largest_scale_error), error(s.rotation_deg), error(s.translation),
                              milliseconds(s.seconds_median)});
      }
    }
    return table;
  }

  const TableOptions& options_;
  const Comparison& comparison_;
  const MethodComparison& methods_;
  std::vector<const CaseGroup*> groups_;
  std::vector<const CaseGroup*> scale_groups_;
};

}  // namespace

ComparisonResults comparison_results(const TableOptions& options, const Comparison& comparison) {
  ComparisonResults results{.tables = {}, .methods = compare_methods(comparison)};
  const TableMaker maker(options, comparison, results.methods);
  for (const TableInfo& info : paper_tables()) {
    if (!wanted(options, info.name)) continue;
    if (std::optional<TextTable> table = maker.make(info.name)) results.tables.push_back(*std::move(table));
  }
  return results;
}

}  // namespace consimd::studies
