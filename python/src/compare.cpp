// Comparisons of solvers.
#include <consimd/studies/comparison.hpp>

#include <array>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>
#include <tbb/info.h>

#include <consimd/kernels/isa.hpp>
#include <consimd/solvers/solver.hpp>

#include <consimd/studies/compare_options.hpp>
#include <consimd/studies/comparison_folder.hpp>
#include <consimd/studies/replace_file.hpp>
#include <consimd/studies/study_page.hpp>
#include "bindings.hpp"
#include "interruptible_call.hpp"
#include "outside_solvers.hpp"
#include "study_tables.hpp"

namespace consimd::python {
namespace {

using Numbers = std::optional<std::vector<double>>;

/// As the command's options take them.
std::string to_text(const std::vector<double>& values) { return fmt::format("{}", fmt::join(values, ",")); }

nb::tuple to_tuple(const studies::TextTable& table) {
  return nb::make_tuple(table.name, table.title, table.caption, table.columns, table.rows, studies::to_markdown(table));
}

/// What a dictionary has under a name, if it has it. TypeError that names it where it is of another type.
template <typename Value>
void take(const nb::dict& from, const char* name, Value& value) {
  if (!from.contains(name)) return;
  if (!nb::try_cast(from[name], value)) {
    throw nb::type_error(fmt::format("{}: {} is of the wrong type", name, nb::repr(from[name]).c_str()).c_str());
  }
}

/// Of the dictionary that `_compare.py` makes; none of None.
std::optional<studies::ScanOptions> scan_options(const nb::object& given) {
  if (given.is_none()) return std::nullopt;
  const nb::dict scans = nb::cast<nb::dict>(given);
  studies::ScanOptions options;
  studies::LayoutOptions& layout = options.layout;
  take(scans, "folder", layout.folder);
  take(scans, "layout", layout.layout);
  take(scans, "sequences", layout.sequences);
  take(scans, "pairs", layout.pairs);
  take(scans, "distance", layout.distance);
  take(scans, "pair_list", layout.pair_list);
  take(scans, "ground_truth", layout.ground_truth);
  take(scans, "overlap", layout.overlap);
  take(scans, "skip_consecutive", layout.skip_consecutive);
  take(scans, "noise_bound", options.noise_bound);
  const nb::dict front_end = nb::cast<nb::dict>(scans["front_end"]);
  features::CloudMatchingOptions& matching = options.front_end = studies::layout_front_end(layout.layout);
  take(front_end, "voxel", matching.voxel);
  take(front_end, "normal_radius", matching.normal_radius);
  take(front_end, "descriptor_radius", matching.descriptor_radius);
  take(front_end, "keypoints", matching.keypoints);
  take(front_end, "farthest", matching.farthest);
  take(front_end, "iss", matching.iss);
  take(front_end, "iss_radius", matching.iss_radius);
  take(front_end, "iss_suppression_radius", matching.iss_suppression_radius);
  take(front_end, "best", matching.matches.best);
  take(front_end, "mutual", matching.matches.mutual);
  take(front_end, "ratio", matching.matches.ratio);
  take(front_end, "source_viewpoint", matching.source_viewpoint);
  take(front_end, "target_viewpoint", matching.target_viewpoint);
  take(front_end, "missing", options.missing);
  return options;
}

/// Reading scans takes a while, so Ctrl-C ends it. What a data set lacks becomes a warning.
studies::Comparison prepared(const studies::CompareOptions& options, std::optional<int> threads) {
  std::atomic<bool> stop = false;
  std::vector<std::string> notes;
  std::optional<studies::Comparison> comparison;
  const studies::PreparationControl control{
      .on_scan =
          [&](std::size_t, std::size_t) {
            if (stop) throw std::runtime_error("stopped");  // nobody sees it: the signal's own exception is raised
          },
      .on_note = [&](const std::string& note) { notes.push_back(note); }};
  call_interruptibly(
      [&] {
        with_threads(threads, [&] { comparison.emplace(studies::make_comparison(options, std::nullopt, control)); });
      },
      {.request_stop = [&] { stop = true; }});
  for (const std::string& note : notes) {
    if (PyErr_WarnEx(PyExc_UserWarning, note.c_str(), 1) != 0) throw nb::python_error();
  }
  return *std::move(comparison);
}

nb::tuple run(const std::optional<std::filesystem::path>& cases, std::vector<std::string> synthetic,
              const nb::object& scans, std::uint32_t trials, std::size_t points, const Numbers& outliers,
              const Numbers& sigma, std::vector<std::string> tables, std::optional<std::vector<std::string>> solvers,
              const std::vector<OutsideEntry>& outside, double time_limit, std::string_view filter,
              std::string thresholds, std::optional<std::vector<std::uint32_t>> iterations,
              std::uint32_t iteration_problems, Numbers scales, std::uint64_t seed, std::uint32_t seeds,
              std::optional<int> threads, const std::optional<std::filesystem::path>& folder_path, bool fresh,
              const std::optional<std::filesystem::path>& report, std::string_view command,
              const nb::object& progress) {
  studies::CompareOptions options;
  if (cases) options.cases = cases->string();
  options.scans = scan_options(scans);
  if (options.scans && folder_path) options.scans->cache = studies::correspondences_folder(*folder_path);
  options.synthetic = std::move(synthetic);
  options.trials = trials;
  options.points = points;
  if (outliers) options.outliers = to_text(*outliers);
  if (sigma) options.sigma = to_text(*sigma);
  options.tables.tables = std::move(tables);
  if (solvers) options.tables.solvers = std::move(*solvers);
  const auto stop = std::make_shared<std::atomic<bool>>(false);
  options.tables.outside = outside_solvers(outside, time_limit, stop);
  // However a solver's options were spelt, its name in the tables is one.
  for (std::string& solver : options.tables.solvers) solver = solver_label(options.tables.outside, solver);
  options.tables.filtered = filter_by_name(filter) == Filter::tcf;
  options.tables.preset = std::move(thresholds);
  if (iterations) options.tables.iterations = std::move(*iterations);
  options.iteration_problems = iteration_problems;
  if (scales) options.tables.scales = std::move(*scales);
  options.seed = seed;
  options.seeds = seeds;
  const std::optional<int> limit = checked_threads(threads);
  studies::Comparison comparison = prepared(options, limit);
  const studies::ComparisonFacts facts{.options = studies::option_texts(options),
                                       .isa = to_string(active_isa()),
                                       .threads = limit.value_or(tbb::info::default_concurrency())};
  std::optional<studies::ComparisonFolder> folder;
  if (report) studies::require_writable_page(*report, folder_path.value_or(""));
  if (folder_path) folder.emplace(*folder_path, comparison, facts, fresh);

  run_study(comparison.filled(), comparison.size(), limit, progress, *stop,
            [&](const auto& stop_requested, const auto& step) {
              studies::run_comparison(comparison, {.on_run =
                                                       [&](const studies::RunRecord& record) {
                                                         if (folder) folder->append(record);
                                                         step();
                                                       },
                                                   .stop_requested = stop_requested});
            });
  const studies::ComparisonResults results = studies::comparison_results(options.tables, comparison);
  if (folder) folder->write(comparison, results, facts);
  if (report) {
    const std::string of_comparison = studies::comparison_json(comparison, facts);
    studies::replace_file(*report, studies::comparison_page(comparison, results, of_comparison, command));
  }
  nb::list list;
  for (const studies::TextTable& table : results.tables) list.append(to_tuple(table));
  return nb::make_tuple(to_columns(comparison.done(), studies::kRunColumns), list, to_tables(results.methods));
}

}  // namespace

void bind_compare(nb::module_& module) {
  module.def("group_pair_columns", [] { return meanings(studies::kPairColumns<studies::GroupCell>); });
  module.def("group_solver_columns", [] { return meanings(studies::kSolverColumns<studies::GroupCell>); });
  module.def("group_curve_columns", [] { return meanings(studies::kCurveColumns<studies::GroupCell>); });
  module.def("run_columns", [] { return meanings(studies::kRunColumns); });
  module.def("run_comparison", &run, nb::arg("cases").none(), nb::arg("synthetic"), nb::arg("scans").none(),
             nb::arg("trials"), nb::arg("points"), nb::arg("outliers").none(), nb::arg("sigma").none(),
             nb::arg("tables"), nb::arg("solvers").none(), nb::arg("outside"), nb::arg("time_limit"), nb::arg("filter"),
             nb::arg("thresholds"), nb::arg("iterations").none(), nb::arg("iteration_problems"),
             nb::arg("scales").none(), nb::arg("seed"), nb::arg("seeds"), nb::arg("threads").none(),
             nb::arg("folder").none(), nb::arg("fresh"), nb::arg("report").none(), nb::arg("command"),
             nb::arg("progress").none());
}

}  // namespace consimd::python
