// The noise study.
#include <consimd/studies/sweep.hpp>

#include <filesystem>
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
#include <consimd/studies/study_folder.hpp>
#include "bindings.hpp"
#include "outside_solvers.hpp"
#include "study_tables.hpp"

namespace consimd::python {
namespace {

nb::tuple run(std::size_t points, std::optional<std::vector<double>> outliers, std::optional<std::vector<double>> sigma,
              std::uint32_t trials, std::vector<std::string> solvers, const std::vector<OutsideEntry>& outside,
              double time_limit, std::string_view filter, std::uint64_t seed, std::optional<int> threads,
              const std::optional<std::filesystem::path>& folder_path, bool fresh, const nb::object& progress) {
  studies::SweepOptions options;
  options.points = points;
  if (outliers) options.outlier_ratios = std::move(*outliers);
  if (sigma) options.sigmas = std::move(*sigma);
  options.trials = trials;
  options.solvers = std::move(solvers);
  options.outside = outside_solvers(outside, time_limit);
  options.filter = filter_by_name(filter);
  options.seed = seed;
  const std::optional<int> limit = checked_threads(threads);
  studies::TrialTable table(std::move(options));
  const studies::RunFacts facts{.isa = to_string(active_isa()),
                                .threads = limit.value_or(tbb::info::default_concurrency())};
  std::optional<studies::StudyFolder> folder;
  if (folder_path) folder.emplace(*folder_path, table, facts, fresh);

  run_study(table.filled(), table.size(), limit, progress, [&](const auto& stop_requested, const auto& step) {
    studies::run_sweep(table, {.on_trial =
                                   [&](const studies::TrialRecord& record) {
                                     if (folder) folder->append(record);
                                     step();
                                   },
                               .stop_requested = stop_requested});
  });
  if (folder) folder->finish(table, facts);
  return nb::make_tuple(to_columns(table.records(), studies::kTrialColumns),
                        to_columns(studies::summarise(table).cells(), studies::kCellColumns));
}

}  // namespace

void bind_sweep(nb::module_& module) {
  module.def("trial_columns", [] { return meanings(studies::kTrialColumns); });
  module.def("cell_columns", [] { return meanings(studies::kCellColumns); });
  module.def("run_sweep", &run, nb::arg("points"), nb::arg("outliers").none(), nb::arg("sigma").none(),
             nb::arg("trials"), nb::arg("solvers"), nb::arg("outside"), nb::arg("time_limit"), nb::arg("filter"),
             nb::arg("seed"), nb::arg("threads").none(), nb::arg("folder").none(), nb::arg("fresh"),
             nb::arg("progress").none());
}

}  // namespace consimd::python
