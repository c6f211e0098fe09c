// The results of a study, finished or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/shard.hpp>
#include <consimd/studies/sweep_options.hpp>
#include <consimd/studies/trial_record.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A slot for every trial of a study, ordered by solver, condition, outlier ratio, noise level and trial: whoever fills
/// them, and when, the table reads the same.
class TrialTable {
 public:
  /// What a slot holds: the record, some 200 bytes, or a bit that tells whether the trial is done. A study in a folder
  /// needs no more: the folder has the records.
  enum class Keep : std::uint8_t { records, marks };

  /// For the whole study, or a shard: problems, numbered by condition, outlier ratio, noise level and trial, are dealt
  /// out, each
  /// with all its solvers. Throws std::invalid_argument on bad options.
  explicit TrialTable(SweepOptions options, std::optional<Shard> shard = {}, Keep keep = Keep::records);

  [[nodiscard]] const SweepOptions& options() const noexcept { return options_; }
  [[nodiscard]] const std::optional<Shard>& shard() const noexcept { return shard_; }
  /// Trials that are to be run: those of the study or of the shard.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t filled() const noexcept { return filled_count_; }
  [[nodiscard]] bool complete() const noexcept { return filled() == size(); }

  /// What the problems of a cell have in common.
  struct Cell {
    Condition condition;
    double outlier_ratio;
    double sigma;
  };

  /// Cells of one solver, numbered by condition, outlier ratio and noise level.
  [[nodiscard]] std::size_t problem_cells() const { return options_.cells() / options_.solvers.size(); }
  [[nodiscard]] Cell problem_cell(std::size_t cell) const {
    const std::size_t levels = options_.sigmas.size(), ratios = options_.outlier_ratios.size();
    return {conditions_[cell / levels / ratios], options_.outlier_ratios[cell / levels % ratios],
            options_.sigmas[cell % levels]};
  }

  /// Whether a problem is to be run.
  [[nodiscard]] bool wants(std::size_t cell, std::uint32_t trial) const {
    return !shard_ || shard_->owns(problem(cell, trial));
  }

  /// `solver`: its position in the list of options().
  [[nodiscard]] bool has(std::size_t solver, std::size_t cell, std::uint32_t trial) const {
    return filled_[slot(solver, cell, trial)];
  }

  /// Whether rows have the columns of a study beyond the paper's.
  [[nodiscard]] bool wide() const noexcept { return wide_; }

  /// The slot of a record. Throws std::invalid_argument if the record is not of this study or shard.
  [[nodiscard]] std::size_t slot_of(const TrialRecord& record) const;
  [[nodiscard]] std::size_t slots() const { return options_.cells() * options_.trials; }

  /// Fills the record's slot; a record that is there already stays. Throws std::invalid_argument if the record is not
  /// of this study or shard.
  void put(TrialRecord record);

  // What only a table that keeps records has.

  /// Calls `take` with every record that is there, in order.
  void for_each(const std::function<void(const TrialRecord&)>& take) const;

  /// All records in order, or those of one cell. Call them on the complete table of a whole study only: slots not
  /// filled hold empty records.
  [[nodiscard]] std::span<const TrialRecord> records() const noexcept { return records_; }
  [[nodiscard]] std::span<const TrialRecord> cell(std::size_t index) const {
    return std::span(records_).subspan(index * options_.trials, options_.trials);
  }

 private:
  [[nodiscard]] std::size_t problem(std::size_t cell, std::uint32_t trial) const {
    return cell * options_.trials + trial;
  }
  [[nodiscard]] std::size_t problems() const { return problem(problem_cells(), 0); }
  [[nodiscard]] std::size_t slot(std::size_t solver, std::size_t cell, std::uint32_t trial) const {
    return solver * problems() + problem(cell, trial);
  }
  [[nodiscard]] std::size_t condition_of(const TrialRecord& record) const;

  SweepOptions options_;
  std::optional<Shard> shard_;
  bool wide_;
  std::vector<Condition> conditions_;
  // Places in the lists of options().
  std::map<double, std::size_t> ratios_, sigmas_;
  std::map<std::string, std::size_t, std::less<>> solvers_;
  std::size_t size_;
  std::vector<TrialRecord> records_;  ///< none if marks are all that is kept
  std::vector<bool> filled_;
  std::size_t filled_count_ = 0;
};

}  // namespace studies
}  // namespace consimd
