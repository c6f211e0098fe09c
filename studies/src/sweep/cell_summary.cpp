#include <consimd/studies/cell_summary.hpp>

#include <algorithm>
#include <span>
#include <utility>

#include "files/csv_rows.hpp"

namespace consimd::studies {
namespace {

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
  std::vector<double> seconds;
  for (const TrialRecord& trial : trials) seconds.push_back(trial.seconds);
  cell.seconds_median = median(std::move(seconds));
  return cell;
}

RatioSummary summarise(std::span<const CellSummary> cells, std::vector<double> seconds) {
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
  row.seconds_median = median(std::move(seconds));
  return row;
}

}  // namespace

std::string to_csv_row(const CellSummary& cell) { return csv_row(kCellColumns, cell); }

void StudySummary::add(const TrialRecord& record) {
  open_.push_back(record);
  failures_.add(record.solver, record.status);
  seconds_.push_back(record.seconds);
  if (open_.size() < trials_) return;
  cells_.push_back(summarise(open_));
  open_.clear();
  if (cells_.size() % levels_ != 0) return;
  rows_.push_back(summarise(std::span(cells_).last(levels_), std::exchange(seconds_, {})));
}

std::vector<RatioSummary> StudySummary::ratios() const {
  const std::size_t ratios = rows_.size() / solvers_;
  std::vector<RatioSummary> ordered;
  for (std::size_t ratio = 0; ratio < ratios; ++ratio) {
    for (std::size_t solver = 0; solver < solvers_; ++solver) ordered.push_back(rows_[solver * ratios + ratio]);
  }
  return ordered;
}

StudySummary summarise(const TrialTable& table) {
  StudySummary summary(table.options());
  table.for_each([&](const TrialRecord& record) { summary.add(record); });
  return summary;
}

}  // namespace consimd::studies
