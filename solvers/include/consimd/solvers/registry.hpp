// The table of solvers: their names, what they can do, the options that each has, and how to call them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/solver_option.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

/// What a solver is to do, beside its options.
struct SolverTask {
  /// Largest residual of an inlier, caller's unit; finite and > 0.
  double noise_bound = 0.0;
  std::uint64_t seed = 1;
  /// Noise bounds that the given one was chosen from by looking at the data, >= 1: their number counts in the
  /// significance.
  std::uint32_t bounds_tried = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// An option and the value that it is given.
struct OptionSetting {
  std::string name;
  OptionValue value;
};

/// A solver under another name, with options set.
struct Preset {
  std::string name;
  std::string description;
  std::vector<OptionSetting> settings;
};

/// An entry of the table.
struct Solver {
  std::string name;         ///< "tcf"; without colons, commas and equals signs
  std::string description;  ///< one line
  std::string needs;        ///< what it asks of the correspondences; empty: nothing
  std::string memory;       ///< beyond the input
  std::string stops_early;  ///< whether the status says when the search stopped early
  std::string advice;       ///< when to take it
  std::vector<SolverOption> options;
  std::vector<Preset> presets;
  /// Runs the solver. settings: of its options, each once and with a value that it may have; the others have their
  /// defaults. Throws std::invalid_argument on values that do not go together.
  std::function<Registration(const Correspondences&, const SolverTask&, std::span<const OptionSetting>)> run;

  /// Whether it finds the scale of the source where it is asked to: it then has an option `estimate_scale`.
  [[nodiscard]] bool estimates_scale() const;
};

/// The solvers of this build, the default first. For more, put entries of your own behind copies of these and hand the
/// whole to `SolverChoice`.
[[nodiscard]] std::span<const Solver> solvers();

/// Their names in that order, each followed by those of its presets.
[[nodiscard]] std::vector<std::string> solver_names(std::span<const Solver> among = solvers());

/// A solver with some of its options set.
class SolverChoice {
 public:
  /// text: NAME[:OPTION=VALUE]..., NAME that of a solver or a preset: "ransac:max_iterations=10000:confidence=none".
  /// Keeps a reference to the entry. Throws std::invalid_argument that lists what there is on an unknown name, on a bad
  /// value, and on an option that is there twice.
  explicit SolverChoice(std::string_view text, std::span<const Solver> among = solvers());

  /// Sets an option that is not set yet, but by the preset. Throws as above.
  void set(std::string_view option, OptionValue value);
  /// The same from a text OPTION=VALUE.
  void set(std::string_view assignment);

  [[nodiscard]] const Solver& solver() const noexcept { return *solver_; }
  /// Name of the solver or the preset, as given.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /// One line on the solver or the preset.
  [[nodiscard]] const std::string& description() const noexcept;
  /// The options set, without those of the preset, in the order of the table.
  [[nodiscard]] std::vector<OptionSetting> given() const;
  /// What the constructor takes for an equal choice, the same whatever the order of the options and the spelling of
  /// numbers were: a solver's name in studies.
  [[nodiscard]] std::string label() const;
  /// The value of an option: set, of the preset, or its default. Throws on one that the solver lacks.
  [[nodiscard]] const OptionValue& value(std::string_view option) const;
  /// Whether the option estimate_scale is true.
  [[nodiscard]] bool estimates_scale() const;

  [[nodiscard]] Registration run(const Correspondences& correspondences, const SolverTask& task) const;

 private:
  const Solver* solver_ = nullptr;
  const Preset* preset_ = nullptr;
  std::string name_;
  std::vector<OptionSetting> settings_;  // the preset's, then those set, each option once
  std::vector<std::string> given_;       // names of the options set
};

/// Throws std::invalid_argument that lists the solvers that find the scale unless this one does.
void require_scale_estimation(const SolverChoice& choice, std::span<const Solver> among = solvers());

}  // namespace consimd
