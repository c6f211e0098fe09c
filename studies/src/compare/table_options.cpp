#include <consimd/studies/table_options.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <consimd/solvers/registry.hpp>

#include <consimd/studies/success_limits.hpp>
#include <consimd/studies/table_runs.hpp>
#include "compare/table_methods.hpp"

namespace consimd::studies {
using namespace detail;
namespace {

constexpr TableInfo kTables[] = {
    {"data", "what the data are: distances, correspondences, inliers"},
    {"solvers", "recall, errors and time of each solver"},
    {"pairs", "which solver beats which on the same cases, with p-values"},
    {"quantiles", "quantiles of errors with failures counted, efficiency, time to reach a recall"},
    {"pipeline", "the whole way from scans to a verified pose, of --scans"},
    {"boost", "each solver alone and after TCF's filter"},
    {"stages", "outlier removal by the stages of TCF"},
    {"poses", "3R against IRLS against both, after 1R+2R"},
    {"iterations", "recall of plain RANSAC over its iterations at 2 % inliers, with a figure"},
    {"scales", "unknown scale of the source, of the solvers that find it"},
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
  if (options.tables == std::vector<std::string>{"pairs"} && options.solvers.size() < 2) {
    throw std::invalid_argument("table pairs: it needs two solvers or more");
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

}  // namespace consimd::studies
