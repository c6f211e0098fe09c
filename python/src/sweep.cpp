// The noise study.
#include <consimd/studies/sweep.hpp>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <tbb/info.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/study_folder.hpp>
#include <consimd/studies/study_page.hpp>
#include "bindings.hpp"
#include "outside_solvers.hpp"
#include "study_tables.hpp"

namespace consimd::python {
namespace {

template <typename Value, typename Parse>
std::vector<Value> parsed(const std::vector<std::string>& texts, const Parse& parse) {
  std::vector<Value> values;
  values.reserve(texts.size());
  for (const std::string& text : texts) values.push_back(parse(text));
  return values;
}

nb::tuple run(std::vector<std::size_t> points, std::optional<std::vector<double>> outliers,
              std::optional<std::vector<double>> sigma, std::uint32_t trials, std::vector<std::string> solvers,
              const std::vector<OutsideEntry>& outside, double time_limit, std::string_view filter, std::uint64_t seed,
              std::vector<std::string> families, const std::vector<std::string>& scales,
              const std::vector<std::string>& bound_factors, double no_pose, std::optional<int> threads,
              const std::optional<std::filesystem::path>& folder_path, bool fresh,
              const std::optional<std::filesystem::path>& report, std::string_view command,
              const nb::object& progress) {
  studies::SweepOptions options;
  options.points = std::move(points);
  if (outliers) options.outlier_ratios = std::move(*outliers);
  if (sigma) options.sigmas = std::move(*sigma);
  options.trials = trials;
  options.solvers = std::move(solvers);
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  options.outside = outside_solvers(outside, time_limit, stop);
  options.filter = filter_by_name(filter);
  options.seed = seed;
  options.families = std::move(families);
  options.scales = parsed<studies::ScaleKnowledge>(scales, studies::scale_knowledge_by_name);
  options.bound_factors = parsed<studies::BoundFactor>(bound_factors, studies::parse_bound_factor);
  options.no_pose = no_pose;
  const std::optional<int> limit = checked_threads(threads);
  studies::TrialTable table(std::move(options));
  const studies::RunFacts facts{.isa = to_string(active_isa()),
                                .threads = limit.value_or(tbb::info::default_concurrency())};
  std::optional<studies::StudyFolder> folder;
  if (report) studies::require_writable_page(*report, folder_path.value_or(""));
  if (folder_path) folder.emplace(*folder_path, table, facts, fresh);

  run_study(table.filled(), table.size(), limit, progress, *stop, [&](const auto& stop_requested, const auto& step) {
    studies::run_sweep(table, {.on_trial =
                                   [&](const studies::TrialRecord& record) {
                                     if (folder) folder->append(record);
                                     step();
                                   },
                               .stop_requested = stop_requested});
  });
  if (folder) folder->finish(table, facts);
  const studies::StudySummary summary = studies::summarise(table);
  const std::vector<studies::CellSummary>& cells = summary.cells();
  if (report) {
    const std::string of_study = studies::summary_json(table, {facts.isa, facts.threads, true});
    studies::replace_file(*report, studies::sweep_page(summary, of_study, command));
  }
  const nb::tuple compared = to_tables(summary.comparison().value_or(studies::TrialComparison()));
  if (table.wide()) {
    return nb::make_tuple(to_columns(table.records(), studies::kWideTrialColumns),
                          to_columns(cells, studies::kWideCellColumns), compared);
  }
  return nb::make_tuple(to_columns(table.records(), studies::kTrialColumns), to_columns(cells, studies::kCellColumns),
                        compared);
}

}  // namespace

void bind_sweep(nb::module_& module) {
  module.def(
      "wilson_interval",
      [](std::size_t successes, std::size_t trials) {
        const studies::Interval interval = studies::wilson_interval(successes, trials);
        return nb::make_tuple(interval.low, interval.high);
      },
      nb::arg("successes"), nb::arg("trials"),
      nb::sig("def wilson_interval(successes: int, trials: int) -> tuple[float, float]"),
      "Wilson's score interval, 95 %, of a probability of which so many of so many trials succeeded: (low, high), as\n"
      "recall_low and recall_high of a study. (0, 1) without trials. ValueError if there are more successes.");
  module.def("trial_columns", [] { return meanings(studies::kTrialColumns); });
  module.def("cell_columns", [] { return meanings(studies::kCellColumns); });
  module.def("pair_columns", [] { return meanings(studies::kPairColumns<studies::ProblemCell>); });
  module.def("solver_columns", [] { return meanings(studies::kSolverColumns<studies::ProblemCell>); });
  module.def("curve_columns", [] { return meanings(studies::kCurveColumns<studies::ProblemCell>); });
  module.def("trial_condition_columns", [] { return meanings(studies::kTrialConditionColumns); });
  module.def("cell_condition_columns", [] { return meanings(studies::kCellConditionColumns); });
  module.def("run_sweep", &run, nb::arg("points"), nb::arg("outliers").none(), nb::arg("sigma").none(),
             nb::arg("trials"), nb::arg("solvers"), nb::arg("outside"), nb::arg("time_limit"), nb::arg("filter"),
             nb::arg("seed"), nb::arg("families"), nb::arg("scales"), nb::arg("bound_factors"), nb::arg("no_pose"),
             nb::arg("threads").none(), nb::arg("folder").none(), nb::arg("fresh"), nb::arg("report").none(),
             nb::arg("command"), nb::arg("progress").none());
}

}  // namespace consimd::python
