// The engine of `consimd compare`: methods on cases, run after run.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/studies/case_group.hpp>
#include <consimd/studies/outside_solver.hpp>
#include <consimd/studies/run_record.hpp>
#include <consimd/studies/shard.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What tables call all groups together; no group may have this name.
inline constexpr std::string_view kAllGroups = "all groups";

/// All runs of a comparison, or of a shard of it, done or not. The order is that of groups, cases, methods and seeds,
/// whoever fills it in, and when.
class Comparison {
 public:
  /// Every method of a group runs `runs` times on each of its cases, with the case's seed, seed + 1, ... A method may
  /// be the name of one of `outside`, alone or after TCF's filter ("tcf+mine"). A shard has the runs on its cases
  /// alone, which are numbered through all groups. Throws std::invalid_argument on a method or a case that is there
  /// twice and on a name that a CSV table cannot hold.
  Comparison(std::vector<CaseGroup> groups, std::uint32_t runs, OutsideSolvers outside = {},
             std::optional<Shard> shard = std::nullopt);

  [[nodiscard]] const std::vector<CaseGroup>& groups() const noexcept { return groups_; }
  [[nodiscard]] std::uint32_t runs() const noexcept { return runs_; }
  [[nodiscard]] const OutsideSolvers& outside() const noexcept { return outside_; }
  [[nodiscard]] const std::optional<Shard>& shard() const noexcept { return shard_; }
  [[nodiscard]] std::size_t size() const noexcept { return slots_.size(); }
  [[nodiscard]] std::size_t filled() const noexcept { return filled_count_; }
  [[nodiscard]] bool complete() const noexcept { return filled() == size(); }

  /// Whether that run is of the comparison and not done.
  [[nodiscard]] bool lacks(std::size_t group, std::size_t case_index, std::string_view method,
                           std::uint64_t seed) const;

  /// Fills the record's slot; one that is there already stays. Throws std::invalid_argument if the record is not of
  /// this comparison.
  void put(RunRecord record);

  /// The runs of a method in a group that are done, in order.
  [[nodiscard]] std::vector<RunRecord> runs_of(std::string_view group, std::string_view method) const;
  /// All that are done, in order.
  [[nodiscard]] std::vector<RunRecord> done() const;

 private:
  using Key = std::tuple<std::string, std::string, std::string, std::uint64_t>;  // group, case, method, seed

  std::vector<CaseGroup> groups_;
  std::uint32_t runs_;
  OutsideSolvers outside_;
  std::optional<Shard> shard_;
  std::map<Key, std::size_t, std::less<>> slots_;
  std::vector<RunRecord> records_;
  std::vector<bool> filled_;
  std::size_t filled_count_ = 0;
};

struct ComparisonControl {
  /// Called after every run, before its record enters the comparison.
  std::function<void(const RunRecord&)> on_run = {};
  /// Told how an outside program failed, and on which case, before `on_run` gets that run.
  std::function<void(const std::string&)> on_failure = {};
  /// Asked before every run; true ends the comparison.
  std::function<bool()> stop_requested = {};
};

/// Makes the runs that are missing, one at a time, so that each has all threads of the caller's arena and times are not
/// disturbed by one another. Starts with the first case of every group, so that a comparison stopped early covers all
/// groups. What an outside solver throws, and a wrong answer (see `run_outside`), end the comparison with that
/// exception.
void run_comparison(Comparison& comparison, const ComparisonControl& control = {});

}  // namespace studies
}  // namespace consimd
