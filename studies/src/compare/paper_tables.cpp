#include <consimd/studies/paper_tables.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/solvers/registry.hpp>

#include <consimd/studies/method.hpp>
#include <consimd/studies/run_statistics.hpp>

namespace consimd::studies {
namespace {

constexpr TableInfo kTables[] = {
    {"data", "what the data are: distances, correspondences, inliers"},
    {"solvers", "recall, errors and time of each solver"},
    {"pipeline", "the whole way from scans to a verified pose, of --scans"},
    {"boost", "each solver alone and after TCF's filter"},
    {"stages", "outlier removal by the stages of TCF"},
    {"poses", "3R against IRLS against both, after 1R+2R"},
    {"iterations", "recall of plain RANSAC over its iterations at 2 % inliers, with a figure"},
    {"scales", "unknown scale of the source, of the solvers that find it"},
};

constexpr std::array kStages{"1R", "2R", "3R", "1R+2R", "1R+3R", "2R+3R", "1R+2R+3R"};
constexpr std::array kPoses{"1R+2R+3R", "1R+2R+IRLS", "1R+2R+3R+IRLS"};
constexpr std::string_view kInputStage = "1R";       // the cheapest method that tells what the data are
constexpr std::string_view kFilterStages = "1R+2R";  // what TCF's filter keeps

constexpr std::string_view kIterationGroup = "2 % inliers";
constexpr std::string_view kIterationRival = "tcf";  // whose recall stands beside plain RANSAC's
constexpr double kIterationOutliers = 0.98;
constexpr double kIterationSigma = 1.0;

constexpr double kScaleOutliers = 0.9;
constexpr std::array kScaleSigmas{0.1, 1.0, 2.5, 5.0};

bool wanted(const TableOptions& options, std::string_view table) {
  return std::ranges::find(options.tables, table) != options.tables.end();
}

std::string scale_group_name(double scale) { return fmt::format("scale {}", scale); }

/// Outside solvers are asked for rigid motions alone.
bool finds_scale(const TableOptions& options, std::string_view solver) {
  return find_outside(options.outside, solver) == nullptr && SolverChoice(solver).solver().estimates_scale();
}

/// Says what the data are, group by group, those of one kind together.
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

constexpr std::string_view kErrorsCaption =
    "Errors: mean over the successes, as in the paper, and in brackets the median over all runs, failures included.";
constexpr std::string_view kTimeCaption = "Time: median of the whole registration.";

class TableMaker {
 public:
  TableMaker(const TableOptions& options, const Comparison& comparison) : options_(options), comparison_(comparison) {
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

  [[nodiscard]] TextTable make(std::string_view name) const {
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
  std::vector<const CaseGroup*> groups_;
  std::vector<const CaseGroup*> scale_groups_;
};

template <typename T>
void require_distinct(const std::vector<T>& values, std::string_view what) {
  if (values.empty()) throw std::invalid_argument(fmt::format("{}: at least one is needed", what));
  for (auto value = values.begin(); value != values.end(); ++value) {
    if (std::find(values.begin(), value, *value) != value) {
      throw std::invalid_argument(fmt::format("{}: {} is given twice", what, *value));
    }
  }
}

}  // namespace

std::span<const TableInfo> paper_tables() noexcept { return kTables; }

void validate(const TableOptions& options) {
  require_distinct(options.tables, "table");
  for (const std::string& name : options.tables) {
    if (std::ranges::find(kTables, name, &TableInfo::name) != std::end(kTables)) continue;
    std::vector<std::string_view> known;
    for (const TableInfo& table : kTables) known.push_back(table.name);
    throw std::invalid_argument(fmt::format("unknown table '{}'; known: {}", name, fmt::join(known, ", ")));
  }
  require_distinct(options.solvers, "solver");
  require_outside_solvers(options.outside, options.solvers);
  for (const std::string& solver : options.solvers) static_cast<void>(solver_label(options.outside, solver));
  require_known_preset(options.preset);
  require_distinct(options.iterations, "iterations");
  require_distinct(options.scales, "scales");
  for (const double scale : options.scales) {
    if (!(std::isfinite(scale) && scale > 0.0)) {
      throw std::invalid_argument(fmt::format("scales: expected a finite number > 0, got {}", scale));
    }
  }
  if (wanted(options, "pipeline") && scan_methods(options).empty()) {
    throw std::invalid_argument("table pipeline: it runs consimd's own solvers, of which none is given");
  }
  if (wanted(options, "scales") && scale_methods(options).empty()) {
    std::vector<std::string_view> able;
    for (const Solver& solver : solvers()) {
      if (solver.estimates_scale()) able.emplace_back(solver.name);
    }
    throw std::invalid_argument(fmt::format("table scales: solver '{}' needs a known scale, expected one of: {}",
                                            fmt::join(options.solvers, ", "), fmt::join(able, ", ")));
  }
}

std::vector<std::string> methods_of(const TableOptions& options) {
  std::vector<std::string> methods;
  const auto add = [&](std::string_view method) {
    if (std::ranges::find(methods, method) == methods.end()) methods.emplace_back(method);
  };
  if (wanted(options, "data")) add(kInputStage);
  for (const std::string& solver : options.solvers) {
    if (wanted(options, "boost") || (wanted(options, "solvers") && !options.filtered)) add(solver);
    if (wanted(options, "boost") || (wanted(options, "solvers") && options.filtered)) add(after_filter(solver));
  }
  if (wanted(options, "boost")) add(kFilterStages);
  if (wanted(options, "stages")) std::ranges::for_each(kStages, add);
  if (wanted(options, "poses")) std::ranges::for_each(kPoses, add);
  return methods;
}

std::vector<std::string> scan_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "pipeline")) return methods;
  for (const std::string& solver : options.solvers) {
    if (find_outside(options.outside, solver) == nullptr) methods.push_back(from_scans(solver));
  }
  return methods;
}

std::vector<std::string> iteration_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "iterations")) return methods;
  for (const std::uint32_t n : options.iterations) methods.push_back(plain_ransac(n));
  methods.emplace_back(kIterationRival);
  return methods;
}

std::vector<std::string> scale_methods(const TableOptions& options) {
  std::vector<std::string> methods;
  if (!wanted(options, "scales")) return methods;
  for (const std::string& solver : options.solvers) {
    if (finds_scale(options, solver)) methods.push_back(with_scale(solver));
  }
  return methods;
}

CaseGroup iteration_group(const TableOptions& options, std::uint32_t problems, std::uint64_t seed) {
  CaseGroup group =
      noise_groups(
          {.outlier_ratios = {kIterationOutliers}, .sigmas = {kIterationSigma}, .trials = problems, .seed = seed})
          .front();
  group.name = kIterationGroup;
  group.provenance += fmt::format(", sigma {:g} m", kIterationSigma);
  group.methods = iteration_methods(options);
  return group;
}

std::vector<CaseGroup> scale_groups(const TableOptions& options, std::uint32_t trials, std::uint64_t seed) {
  std::vector<CaseGroup> groups;
  if (!wanted(options, "scales")) return groups;
  for (const double scale : options.scales) {
    CaseGroup group = noise_groups({.outlier_ratios = {kScaleOutliers},
                                    .sigmas = {kScaleSigmas.begin(), kScaleSigmas.end()},
                                    .trials = trials,
                                    .seed = seed,
                                    .scale = scale})
                          .front();
    group.name = scale_group_name(scale);
    group.provenance += fmt::format(", sigma {} m, source divided by the scale", fmt::join(kScaleSigmas, ", "));
    group.methods = scale_methods(options);
    groups.push_back(std::move(group));
  }
  return groups;
}

std::vector<TextTable> make_tables(const TableOptions& options, const Comparison& comparison) {
  const TableMaker maker(options, comparison);
  std::vector<TextTable> tables;
  for (const TableInfo& info : kTables) {
    if (wanted(options, info.name)) tables.push_back(maker.make(info.name));
  }
  return tables;
}

}  // namespace consimd::studies
