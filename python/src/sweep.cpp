// The noise study.
#include <consimd/studies/sweep.hpp>

#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>
#include <tbb/info.h>

#include <consimd/kernels/isa.hpp>

#include <consimd/studies/cell_summary.hpp>
#include <consimd/studies/study_folder.hpp>
#include "array_results.hpp"
#include "bindings.hpp"
#include "interruptible_call.hpp"
#include "threads.hpp"

namespace consimd::python {
namespace {

using studies::CellSummary;
using studies::TrialRecord;

/// A column of a table: get(row) of every row, as an array, or as a list of str.
template <typename Rows, typename Get>
nb::object column(const Rows& rows, const Get& get) {
  using Value = std::remove_cvref_t<decltype(get(rows.front()))>;
  if constexpr (std::is_same_v<Value, std::string>) {
    nb::list list;
    for (const auto& row : rows) list.append(get(row));
    return list;
  } else {
    std::vector<Value> values;
    values.reserve(rows.size());
    for (const auto& row : rows) values.push_back(get(row));
    return nb::cast(to_array(std::move(values)));
  }
}

nb::dict to_columns(std::span<const TrialRecord> rows) {
  nb::dict columns;
  columns["solver"] = column(rows, [](const TrialRecord& r) { return r.solver; });
  columns["outlier_ratio"] = column(rows, [](const TrialRecord& r) { return r.outlier_ratio; });
  columns["sigma"] = column(rows, [](const TrialRecord& r) { return r.sigma; });
  columns["trial"] = column(rows, [](const TrialRecord& r) { return r.trial; });
  columns["seed"] = column(rows, [](const TrialRecord& r) { return r.seed; });
  columns["status"] = column(rows, [](const TrialRecord& r) { return r.status; });
  columns["success"] = column(rows, [](const TrialRecord& r) { return std::uint8_t{r.success}; });
  columns["rmse_true_inliers"] = column(rows, [](const TrialRecord& r) { return r.rmse_true_inliers; });
  columns["rotation_error_deg"] = column(rows, [](const TrialRecord& r) { return r.rotation_error_deg; });
  columns["translation_error"] = column(rows, [](const TrialRecord& r) { return r.translation_error; });
  columns["oracle_rotation_error_deg"] = column(rows, [](const TrialRecord& r) { return r.oracle_rotation_error_deg; });
  columns["oracle_translation_error"] = column(rows, [](const TrialRecord& r) { return r.oracle_translation_error; });
  columns["inlier_precision"] = column(rows, [](const TrialRecord& r) { return r.inlier_precision; });
  columns["inlier_recall"] = column(rows, [](const TrialRecord& r) { return r.inlier_recall; });
  columns["seconds"] = column(rows, [](const TrialRecord& r) { return r.seconds; });
  return columns;
}

nb::dict to_columns(const std::vector<CellSummary>& rows) {
  nb::dict columns;
  columns["solver"] = column(rows, [](const CellSummary& r) { return r.solver; });
  columns["outlier_ratio"] = column(rows, [](const CellSummary& r) { return r.outlier_ratio; });
  columns["sigma"] = column(rows, [](const CellSummary& r) { return r.sigma; });
  columns["trials"] = column(rows, [](const CellSummary& r) { return r.trials; });
  columns["recall"] = column(rows, [](const CellSummary& r) { return r.recall; });
  columns["recall_low"] = column(rows, [](const CellSummary& r) { return r.recall_interval.low; });
  columns["recall_high"] = column(rows, [](const CellSummary& r) { return r.recall_interval.high; });
  columns["rotation_error_deg_mean"] = column(rows, [](const CellSummary& r) { return r.error.rotation_deg; });
  columns["translation_error_mean"] = column(rows, [](const CellSummary& r) { return r.error.translation; });
  columns["oracle_rotation_error_deg_mean"] =
      column(rows, [](const CellSummary& r) { return r.oracle_error.rotation_deg; });
  columns["oracle_translation_error_mean"] =
      column(rows, [](const CellSummary& r) { return r.oracle_error.translation; });
  columns["seconds_median"] = column(rows, [](const CellSummary& r) { return r.seconds_median; });
  return columns;
}

nb::tuple run(std::size_t points, std::optional<std::vector<double>> outliers, std::optional<std::vector<double>> sigma,
              std::uint32_t trials, std::vector<std::string> solvers, std::string_view filter, std::uint64_t seed,
              std::optional<int> threads, const std::optional<std::filesystem::path>& folder_path, bool fresh,
              const nb::object& progress) {
  studies::SweepOptions options;
  options.points = points;
  if (outliers) options.outlier_ratios = std::move(*outliers);
  if (sigma) options.sigmas = std::move(*sigma);
  options.trials = trials;
  options.solvers = std::move(solvers);
  options.filter = filter_by_name(filter);
  options.seed = seed;
  const std::optional<int> limit = checked_threads(threads);
  studies::TrialTable table(std::move(options));
  const studies::RunFacts facts{.isa = to_string(active_isa()),
                                .threads = limit.value_or(tbb::info::default_concurrency())};
  std::optional<studies::StudyFolder> folder;
  if (folder_path) folder.emplace(*folder_path, table, facts, fresh);

  std::atomic<bool> stop = false;
  std::atomic<std::size_t> done = table.filled();
  const studies::SweepControl control{.on_trial =
                                          [&](const TrialRecord& record) {
                                            if (folder) folder->append(record);
                                            ++done;
                                          },
                                      .stop_requested = [&] { return stop.load(); }};
  const auto tell = [&] {
    if (!progress.is_none()) progress(done.load(), table.size());
  };
  // Waited for in every case, so it may use what is on this stack.
  call_interruptibly([&] { with_threads(limit, [&] { studies::run_sweep(table, control); }); },
                     {.request_stop = [&] { stop = true; }, .look_in = tell});
  tell();
  if (folder) folder->finish(table, facts);
  return nb::make_tuple(to_columns(table.records()), to_columns(studies::summarise_cells(table)));
}

}  // namespace

void bind_sweep(nb::module_& module) {
  module.def("run_sweep", &run, nb::arg("points"), nb::arg("outliers").none(), nb::arg("sigma").none(),
             nb::arg("trials"), nb::arg("solvers"), nb::arg("filter"), nb::arg("seed"), nb::arg("threads").none(),
             nb::arg("folder").none(), nb::arg("fresh"), nb::arg("progress").none());
}

}  // namespace consimd::python
