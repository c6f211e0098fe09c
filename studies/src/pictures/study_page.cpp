#include <consimd/studies/study_page.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/run_statistics.hpp>
#include <consimd/studies/statistics.hpp>
#include <consimd/studies/table_columns.hpp>

#include "files/json_text.hpp"
#include "pictures/page_sources.hpp"
#include "pictures/page_text.hpp"

namespace consimd::studies {
namespace {

// ---- What the page tells of the run.

/// A table row for each key whose value is no list of objects; those of an object are told one by one.
void append_facts(std::string& rows, const Json& json, const std::string& above) {
  for (const auto& [key, value] : json.items()) {
    if (key == "solver_options") continue;  // digests, which tell people nothing
    const std::string name = above.empty() ? key : fmt::format("{} {}", above, key);
    if (value.is_object()) {
      append_facts(rows, value, name);
    } else if (!value.is_array() || value.empty() || !value.front().is_object()) {
      rows += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name),
                          escaped(value.is_string() ? value.get<std::string>() : value.dump()));
    }
  }
}

std::string facts_of(std::string_view summary) {
  std::string rows;
  append_facts(rows, parse_json(summary), "");
  return "<h2>What was run, and on what</h2>\n<table class=\"facts\">\n" + rows + "</table>";
}

std::string page_of(std::string_view title, const Json& data, std::string_view summary, std::string_view command) {
  const std::string facts = facts_of(summary), text = page_json(data), shown = escaped(command);
  const std::array<std::pair<std::string_view, std::string_view>, 5> values{
      {{"title", title}, {"command", shown}, {"facts", facts}, {"data", text}, {"script", kStudyScript}}};
  return filled(kStudyPage, values);
}

// ---- Tables of the page, as study_page.js reads them.

/// A cell; what JSON has no number for is spelt as in the CSV files.
template <typename Value>
Json cell_json(const Value& value) {
  if constexpr (std::is_floating_point_v<Value>) {
    if (!std::isfinite(value)) return fmt::format("{}", value);
  }
  return value;
}

template <typename Row, typename... Members>
Json table_json(std::string_view name, std::string_view title, std::span<const Row> rows,
                const std::tuple<Column<Members>...>& columns) {
  Json json{{"name", name},
            {"title", title},
            {"caption", Json::array()},
            {"columns", Json::array()},
            {"meanings", Json::array()},
            {"rows", Json::array()}};
  for_each_column(columns, [&](const auto& column) {
    json["columns"].push_back(column.name);
    json["meanings"].push_back(column.meaning);
  });
  for (const Row& row : rows) {
    Json cells;
    for_each_column(columns,
                    [&](const auto& column) { cells[std::string(column.name)] = cell_json(column.value(row)); });
    json["rows"].push_back(std::move(cells));
  }
  return json;
}

Json table_json(const TextTable& table) {
  Json json{{"name", "table_" + table.name},
            {"title", table.title},
            {"caption", table.caption},
            {"columns", table.columns},
            {"rows", Json::array()}};
  for (const std::vector<std::string>& cells : table.rows) {
    Json row;
    for (std::size_t i = 0; i < cells.size(); ++i) row[table.columns[i]] = cells[i];
    json["rows"].push_back(std::move(row));
  }
  return json;
}

// ---- Figures of a table.

Json success_chart() {
  return {{"title", "Success, %"},        {"y", "recall"}, {"low", "recall_low"}, {"high", "recall_high"},
          {"range", Json::array({0, 1})}, {"factor", 100}};
}

Json time_chart() {
  return {{"title", "Median time of a registration, ms"}, {"y", "seconds_median"}, {"factor", 1000}, {"log", true}};
}

Json error_chart(std::string_view title, const std::string& measure) {
  return {{"title", title},
          {"y", measure},
          {"reference", "oracle_" + measure},
          {"reference_name", "least squares on the true inliers"},
          {"log", true}};
}

// ---- Solvers beside each other.

/// Their tables, with recall over the limit of success as a figure. curve_keys: the columns that tell panels apart.
template <typename Cell>
void append_solver_comparison(Json& tables, const SolverComparison<Cell>& comparison, Json curve_keys) {
  if (comparison.pairs.empty()) return;
  const auto add = [&](std::string_view name, std::string_view title, const auto& rows, const auto& columns) {
    tables.push_back(table_json(name, title, std::span(rows), columns));
  };
  add("pairs", "Pairs of solvers on the same problems", comparison.pairs, kPairColumns<Cell>);
  add("precision", "Precision and speed of solvers", comparison.solvers, kSolverColumns<Cell>);
  add("curves", "Recall over the limit of success", comparison.curves, kCurveColumns<Cell>);
  Json& curves = tables.back();
  curves["series"] = "solver";
  curve_keys.push_back("solver");
  curve_keys.push_back("threshold");
  curves["keys"] = std::move(curve_keys);
  curves["charts"] = Json::array({success_chart()});
  curves["charts"][0]["title"] = "Success over its limit, %";
}

// ---- The noise study.

/// How a solver did over all cells.
struct SolverSummary {
  std::string solver;
  std::size_t cells = 0;
  std::uint64_t trials = 0;
  std::uint64_t successes = 0;
  double recall = 0.0;
  Interval recall_interval = {};
  double recall_min = 1.0;
  PoseError worst_ratio = {};
  double seconds_median = 0.0;
};

constexpr std::tuple kOverviewColumns{
    Column{"solver", &SolverSummary::solver, "name of the solver"},
    Column{"cells", &SolverSummary::cells, "of the study"},
    Column{"trials", &SolverSummary::trials, "with a true pose, over all cells"},
    Column{"successes", &SolverSummary::successes, "of them"},
    Column{"recall", &SolverSummary::recall, "share of successes"},
    Column{"recall_low", member_of(&SolverSummary::recall_interval, &Interval::low),
           "lower end of its 95 % Wilson interval"},
    Column{"recall_high", member_of(&SolverSummary::recall_interval, &Interval::high), "upper end of that interval"},
    Column{"recall_min", &SolverSummary::recall_min, "that of the cell with the fewest successes"},
    Column{"worst_rotation_ratio", member_of(&SolverSummary::worst_ratio, &PoseError::rotation_deg),
           "largest quotient of a cell's mean rotation error and the oracle's"},
    Column{"worst_translation_ratio", member_of(&SolverSummary::worst_ratio, &PoseError::translation),
           "the same of the translation"},
    Column{"seconds_median", &SolverSummary::seconds_median, "median over the cells of their median times"},
};

std::vector<SolverSummary> by_solver(std::span<const CellSummary> cells) {
  std::vector<SolverSummary> solvers;
  std::map<std::string, std::vector<double>, std::less<>> seconds;
  for (const CellSummary& cell : cells) {
    auto solver = std::ranges::find(solvers, cell.solver, &SolverSummary::solver);
    if (solver == solvers.end()) solver = solvers.insert(solvers.end(), SolverSummary{.solver = cell.solver});
    ++solver->cells;
    const std::uint32_t with_pose = cell.trials - cell.without_pose;
    if (with_pose == 0) continue;
    solver->trials += with_pose;
    solver->successes += static_cast<std::uint64_t>(std::llround(cell.recall * with_pose));
    solver->recall_min = std::min(solver->recall_min, cell.recall);
    PoseError& worst = solver->worst_ratio;
    worst.rotation_deg = std::max(worst.rotation_deg, cell.error.rotation_deg / cell.oracle_error.rotation_deg);
    worst.translation = std::max(worst.translation, cell.error.translation / cell.oracle_error.translation);
    seconds[cell.solver].push_back(cell.seconds_median);
  }
  for (SolverSummary& solver : solvers) {
    solver.recall = static_cast<double>(solver.successes) / static_cast<double>(solver.trials);
    solver.recall_interval = wilson_interval(solver.successes, solver.trials);
    solver.seconds_median = median(seconds[solver.solver]);
  }
  return solvers;
}

/// Adds the names of the columns before the one called `end`.
template <typename... Members>
void add_keys(const std::tuple<Column<Members>...>& columns, std::string_view end, Json& keys) {
  bool key = true;
  for_each_column(columns, [&](const auto& column) {
    key = key && column.name != end;
    if (key) keys.push_back(column.name);
  });
}

/// The columns that tell cells apart.
Json cell_keys(bool wide) {
  Json keys = Json::array();
  if (wide) add_keys(kCellConditionColumns, "success_share", keys);
  add_keys(kCellColumns, "trials", keys);
  return keys;
}

// ---- Comparisons.

/// How a method did in a group of cases.
struct MethodSummary {
  std::string group;
  std::string method;
  std::size_t runs = 0;
  RunStatistics statistics = {};
};

constexpr auto of_statistics(auto inner) { return member_of(&MethodSummary::statistics, inner); }

constexpr std::tuple kMethodColumns{
    Column{"group", &MethodSummary::group, "of cases"},
    Column{"method", &MethodSummary::method, "solver, with what goes before it"},
    Column{"runs", &MethodSummary::runs, "done: cases times seeds"},
    Column{"recall", of_statistics(&RunStatistics::recall), "share of successes"},
    Column{"recall_low", [](auto& row) -> decltype(auto) { return (row.statistics.recall_interval.low); },
           "lower end of its 95 % Wilson interval"},
    Column{"recall_high", [](auto& row) -> decltype(auto) { return (row.statistics.recall_interval.high); },
           "upper end of that interval"},
    Column{"rotation_error_deg_median",
           [](auto& row) -> decltype(auto) { return (row.statistics.rotation_deg.median_of_all); },
           "over all runs, one without a pose counting as an infinite error, degrees"},
    Column{"translation_error_median",
           [](auto& row) -> decltype(auto) { return (row.statistics.translation.median_of_all); },
           "the same of the translation, unit of the cases"},
    Column{"seconds_median", of_statistics(&RunStatistics::seconds_median), "median time of a registration"},
};

std::vector<MethodSummary> by_method(const Comparison& comparison) {
  std::vector<MethodSummary> methods;
  for (const CaseGroup& group : comparison.groups()) {
    for (const std::string& method : group.methods) {
      const std::vector<RunRecord> runs = comparison.runs_of(group.name, method);
      if (!runs.empty()) methods.push_back({group.name, method, runs.size(), run_statistics(runs)});
    }
  }
  return methods;
}

std::string counted(std::size_t number, std::string_view noun) {
  return fmt::format("{} {}{}", grouped(number), noun, number == 1 ? "" : "s");
}

}  // namespace

std::string sweep_page(const StudySummary& study, std::string_view summary, std::string_view command) {
  const std::span<const CellSummary> cells = study.cells();
  const std::vector<SolverSummary> solvers = by_solver(cells);
  std::size_t trials = 0;
  for (const CellSummary& cell : cells) trials += cell.trials;
  Json overview = table_json("solvers", "Over all cells", std::span(solvers), kOverviewColumns);
  Json all = study.wide() ? table_json("cells", "All cells", cells, kWideCellColumns)
                          : table_json("cells", "All cells", cells, kCellColumns);
  all["caption"].push_back("Errors are means over all trials with a true pose, failures included.");
  all["series"] = "solver";
  all["keys"] = cell_keys(study.wide());
  all["charts"] = Json::array({success_chart(), error_chart("Mean rotation error, degrees", "rotation_error_deg_mean"),
                               error_chart("Mean translation error, m", "translation_error_mean"), time_chart()});
  Json tables = Json::array({std::move(overview), std::move(all)});
  if (const std::optional<TrialComparison> comparison = study.comparison()) {
    Json keys = Json::array();
    add_keys(ProblemCell::columns<CurveRow<ProblemCell>>(), "sigma", keys);
    append_solver_comparison(tables, *comparison, std::move(keys));
  }
  const Json data{
      {"summary", Json::array({fmt::format("{} in {}, {}.", counted(trials, "trial"), counted(cells.size(), "cell"),
                                           counted(solvers.size(), "solver"))})},
      {"tables", std::move(tables)}};
  return page_of("Noise study", data, summary, command);
}

std::string comparison_page(const Comparison& comparison, const ComparisonResults& results, std::string_view summary,
                            std::string_view command) {
  const std::vector<MethodSummary> methods = by_method(comparison);
  Json all = table_json("methods", "All methods", std::span(methods), kMethodColumns);
  all["series"] = "method";
  all["keys"] = Json::array({"group", "method"});
  all["charts"] = Json::array({success_chart(), time_chart()});
  Json of_page = Json::array({std::move(all)});
  append_solver_comparison(of_page, results.methods, Json::array({"group"}));
  for (const TextTable& table : results.tables) of_page.push_back(table_json(table));
  const Json data{{"summary", Json::array({fmt::format("{} of {} in {} of cases.", grouped(comparison.filled()),
                                                       counted(comparison.size(), "run"),
                                                       counted(comparison.groups().size(), "group"))})},
                  {"tables", std::move(of_page)}};
  return page_of("Comparison of solvers", data, summary, command);
}

void require_writable_page(const std::filesystem::path& page, const std::filesystem::path& folder) {
  if (page.extension() != ".html" && page.extension() != ".htm") {
    throw std::invalid_argument(
        fmt::format("{}: expected a name that ends in .html, since a page is written", page.string()));
  }
  const auto absolute = [](const std::filesystem::path& path) { return std::filesystem::weakly_canonical(path); };
  if (!folder.empty() && absolute(page).parent_path() == absolute(folder / "").parent_path()) {
    require_writable_folder(folder);
  }
  require_replaceable(page);
}

}  // namespace consimd::studies
