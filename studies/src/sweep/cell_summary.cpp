#include <consimd/studies/cell_summary.hpp>

#include <algorithm>
#include <span>

#include "files/csv_rows.hpp"

namespace consimd::studies {
namespace {

double median_seconds(std::span<const TrialRecord> trials) {
  std::vector<double> seconds;
  for (const TrialRecord& trial : trials) seconds.push_back(trial.seconds);
  return median(std::move(seconds));
}

CellSummary summarise(std::span<const TrialRecord> trials) {
  CellSummary cell{.solver = trials.front().solver,
                   .outlier_ratio = trials.front().outlier_ratio,
                   .sigma = trials.front().sigma,
                   .trials = static_cast<std::uint32_t>(trials.size())};
  std::size_t successes = 0;
  for (const TrialRecord& trial : trials) {
    successes += trial.success;
    cell.error.rotation_deg += trial.rotation_error_deg;
    cell.error.translation += trial.translation_error;
    cell.oracle_error.rotation_deg += trial.oracle_rotation_error_deg;
    cell.oracle_error.translation += trial.oracle_translation_error;
  }
  const auto count = static_cast<double>(trials.size());
  for (PoseError* error : {&cell.error, &cell.oracle_error}) {
    error->rotation_deg /= count;
    error->translation /= count;
  }
  cell.recall = static_cast<double>(successes) / count;
  cell.recall_interval = wilson_interval(successes, trials.size());
  cell.seconds_median = median_seconds(trials);
  return cell;
}

RatioSummary summarise(std::span<const CellSummary> cells, std::span<const TrialRecord> trials) {
  RatioSummary row{.solver = cells.front().solver, .outlier_ratio = cells.front().outlier_ratio, .recall_min = 1.0};
  const auto count = static_cast<double>(cells.size());
  for (const CellSummary& cell : cells) {
    row.recall_min = std::min(row.recall_min, cell.recall);
    row.recall_mean += cell.recall / count;
    row.error.rotation_deg += cell.error.rotation_deg / count;
    row.error.translation += cell.error.translation / count;
    row.oracle_error.rotation_deg += cell.oracle_error.rotation_deg / count;
    row.oracle_error.translation += cell.oracle_error.translation / count;
    row.worst_ratio.rotation_deg =
        std::max(row.worst_ratio.rotation_deg, cell.error.rotation_deg / cell.oracle_error.rotation_deg);
    row.worst_ratio.translation =
        std::max(row.worst_ratio.translation, cell.error.translation / cell.oracle_error.translation);
  }
  row.seconds_median = median_seconds(trials);
  return row;
}

}  // namespace

std::string to_csv_row(const CellSummary& cell) { return csv_row(kCellColumns, cell); }

std::vector<CellSummary> summarise_cells(const TrialTable& table) {
  std::vector<CellSummary> cells;
  for (std::size_t cell = 0; cell < table.options().cells(); ++cell) cells.push_back(summarise(table.cell(cell)));
  return cells;
}

std::vector<RatioSummary> summarise_ratios(const TrialTable& table) {
  const SweepOptions& options = table.options();
  const std::vector<CellSummary> cells = summarise_cells(table);
  const std::size_t levels = options.sigmas.size();
  std::vector<RatioSummary> rows;
  for (std::size_t ratio = 0; ratio < options.outlier_ratios.size(); ++ratio) {
    for (std::size_t solver = 0; solver < options.solvers.size(); ++solver) {
      const std::size_t first = (solver * options.outlier_ratios.size() + ratio) * levels;
      rows.push_back(summarise(std::span(cells).subspan(first, levels),
                               table.records().subspan(first * options.trials, levels * options.trials)));
    }
  }
  return rows;
}

}  // namespace consimd::studies
