#include <consimd/studies/cell_summary.hpp>

#include <algorithm>
#include <span>
#include <string_view>
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
  std::size_t posed = 0;
  for (const TrialRecord& trial : trials) {
    if (!trial.true_pose) continue;
    ++posed;
    successes += trial.success;
    cell.error.rotation_deg += trial.rotation_error_deg;
    cell.error.translation += trial.translation_error;
    cell.oracle_error.rotation_deg += trial.oracle_rotation_error_deg;
    cell.oracle_error.translation += trial.oracle_translation_error;
  }
  const auto count = static_cast<double>(posed);
  for (PoseError* error : {&cell.error, &cell.oracle_error}) {
    error->rotation_deg /= count;
    error->translation /= count;
  }
  cell.recall = static_cast<double>(successes) / count;
  cell.recall_interval = wilson_interval(successes, posed);
  std::vector<double> seconds;
  for (const TrialRecord& trial : trials) seconds.push_back(trial.seconds);
  cell.seconds_median = median(std::move(seconds));
  return cell;
}

/// Adds what a study beyond the paper's tells besides.
void add_outcomes(CellSummary& cell, std::span<const TrialRecord> trials) {
  const TrialRecord& first = trials.front();
  cell.family = first.family;
  cell.scale = first.scale;
  cell.points = first.points;
  cell.bound_factor = first.bound_factor;
  const auto share = [&](const auto& holds) {
    return static_cast<double>(std::ranges::count_if(trials, holds)) / static_cast<double>(trials.size());
  };
  const auto ended = [](std::string_view outcome) {
    return [outcome](const TrialRecord& trial) { return trial.outcome == outcome; };
  };
  cell.outcomes = {share(ended(kRight)), share(ended(kWrong)), share(ended(kRefused)), share(ended(kAmbiguous))};
  std::size_t within = 0;
  for (const TrialRecord& trial : trials) {
    within += trial.true_pose && trial.oracle_rmse_true_inliers < 3.0 * trial.sigma;
    cell.without_pose += !trial.true_pose;
    cell.wrong_without_pose += !trial.true_pose && trial.outcome == kWrong;
  }
  cell.oracle_within_3_sigma = static_cast<double>(within) / static_cast<double>(trials.size() - cell.without_pose);
}

void set_condition(TrialRecord& record, const Condition& condition) {
  record.family = condition.family;
  record.scale = to_string(condition.scale);
  record.points = condition.points;
  record.bound_factor = to_string(condition.bound_factor);
}

RatioSummary summarise(std::span<const CellSummary> cells, std::vector<double> seconds) {
  RatioSummary row{.solver = cells.front().solver, .outlier_ratio = cells.front().outlier_ratio, .recall_min = 1.0};
  const auto count = static_cast<double>(cells.size());
  for (const CellSummary& cell : cells) {
    row.recall_min = std::min(row.recall_min, cell.recall);
    row.recall_mean += cell.recall / count;
    row.outcomes.right += cell.outcomes.right / count;
    row.outcomes.wrong += cell.outcomes.wrong / count;
    row.outcomes.refused += cell.outcomes.refused / count;
    row.outcomes.ambiguous += cell.outcomes.ambiguous / count;
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

std::string cell_header(bool wide) { return wide ? csv_header(kWideCellColumns) : csv_header(kCellColumns); }

std::string to_csv_row(const CellSummary& cell, bool wide) {
  return wide ? csv_row(kWideCellColumns, cell) : csv_row(kCellColumns, cell);
}

std::optional<TrialComparison> StudySummary::comparison() const {
  if (!compares_) return std::nullopt;
  return compare_solvers(compared_, seed_);
}

void StudySummary::add(const TrialRecord& record) {
  open_.push_back(record);
  if (compares_) {
    compared_.push_back(record);
    if (!wide_) set_condition(compared_.back(), conditions_.front());
  }
  failures_.add(record.solver, record.status);
  seconds_.push_back(record.seconds);
  if (open_.size() < trials_) return;
  cells_.push_back(summarise(open_));
  if (wide_) add_outcomes(cells_.back(), open_);
  open_.clear();
  if (cells_.size() % levels_ != 0) return;
  const std::size_t condition = rows_.size() / ratios_ % conditions_.size();
  rows_.push_back(summarise(std::span(cells_).last(levels_), std::exchange(seconds_, {})));
  rows_.back().condition = conditions_[condition];
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
