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

/// A slot for every trial of a study, ordered by solver, outlier ratio, noise level and trial: whoever fills them, and
/// when, the table reads the same.
class TrialTable {
 public:
  /// What a slot holds: the record, some 200 bytes, or a bit that tells whether the trial is done. A study in a folder
  /// needs no more: the folder has the records.
  enum class Keep : std::uint8_t { records, marks };

  /// For the whole study, or a shard: problems, numbered by outlier ratio, noise level and trial, are dealt out, each
  /// with all its solvers. Throws std::invalid_argument on bad options.
  explicit TrialTable(SweepOptions options, std::optional<Shard> shard = {}, Keep keep = Keep::records);

  [[nodiscard]] const SweepOptions& options() const noexcept { return options_; }
  [[nodiscard]] const std::optional<Shard>& shard() const noexcept { return shard_; }
  /// Trials that are to be run: those of the study or of the shard.
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t filled() const noexcept { return filled_count_; }
  [[nodiscard]] bool complete() const noexcept { return filled() == size(); }

  /// Whether a problem is to be run. Positions in the lists of options(), here and below.
  [[nodiscard]] bool wants(std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return !shard_ || shard_->owns(problem(ratio, sigma, trial));
  }

  [[nodiscard]] bool has(std::size_t solver, std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return filled_[slot(solver, ratio, sigma, trial)];
  }

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
  [[nodiscard]] std::size_t problem(std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return (ratio * options_.sigmas.size() + sigma) * options_.trials + trial;
  }
  [[nodiscard]] std::size_t problems() const { return problem(options_.outlier_ratios.size(), 0, 0); }
  [[nodiscard]] std::size_t slot(std::size_t solver, std::size_t ratio, std::size_t sigma, std::uint32_t trial) const {
    return solver * problems() + problem(ratio, sigma, trial);
  }

  SweepOptions options_;
  std::optional<Shard> shard_;
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
