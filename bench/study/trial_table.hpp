// The results of a study, finished or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "study/sweep_options.hpp"
#include "study/trial_record.hpp"

namespace consimd::study {

/// A slot for every trial of a study, ordered by solver, outlier ratio, noise level and trial: whoever fills them, and
/// when, the table reads the same.
class TrialTable {
 public:
  /// Throws std::invalid_argument on bad options.
  explicit TrialTable(SweepOptions options);

  [[nodiscard]] const SweepOptions& options() const noexcept { return options_; }
  [[nodiscard]] std::size_t size() const noexcept { return records_.size(); }
  [[nodiscard]] std::size_t filled() const noexcept { return filled_count_; }
  [[nodiscard]] bool complete() const noexcept { return filled() == size(); }

  /// Positions in the lists of options().
  [[nodiscard]] bool has(std::size_t solver, std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return filled_[slot(solver, ratio, sigma, trial)];
  }

  /// Fills the record's slot; a record that is there already stays. Throws std::invalid_argument if the record is not
  /// of this study.
  void put(TrialRecord record);

  /// All records in order, or those of one cell. Call them on a complete table only: slots not filled hold empty
  /// records.
  [[nodiscard]] std::span<const TrialRecord> records() const noexcept { return records_; }
  [[nodiscard]] std::span<const TrialRecord> cell(std::size_t index) const {
    return std::span(records_).subspan(index * options_.trials, options_.trials);
  }

 private:
  [[nodiscard]] std::size_t slot(std::size_t solver, std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return ((solver * options_.outlier_ratios.size() + ratio) * options_.sigmas.size() + sigma) * options_.trials +
           trial;
  }

  SweepOptions options_;
  std::vector<TrialRecord> records_;
  std::vector<bool> filled_;
  std::size_t filled_count_ = 0;
};

}  // namespace consimd::study
