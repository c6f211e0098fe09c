// Solvers of a study on the command line: consimd's own, and programs of others.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/studies/outside_program.hpp>

namespace consimd::cli {

/// What --solver, --option, --time-limit and --solver-version say.
struct SolverArguments {
  std::vector<std::string> solvers;   ///< as given: names separated by commas, or a program up to its end
  std::vector<std::string> settings;  ///< for consimd's own
  std::optional<double> time_limit;   ///< for programs
  std::vector<std::string> versions;  ///< NAME=TEXT

  explicit SolverArguments(std::vector<std::string> defaults) : solvers(std::move(defaults)) {}
};

void add_solver_arguments(CLI::App& command, SolverArguments& arguments);

/// Solvers of a study: the names of all in order, and those that are programs, started.
struct StudySolvers {
  std::vector<std::string> names;
  studies::OutsideSolvers outside;
};

/// Throws std::invalid_argument on a bad value, and std::runtime_error where a program does not start.
[[nodiscard]] StudySolvers solvers_of(const SolverArguments& arguments);

/// Failures of outside programs while a study runs.
class FailureReport {
 public:
  void add(const std::string& failure) {
    if (count_++ == 0) first_ = failure;
  }
  /// Tells of them on the standard error stream, if there were any. `steps`: what a study has many of.
  void tell_all(std::string_view steps) const;

 private:
  std::size_t count_ = 0;
  std::string first_;
};

}  // namespace consimd::cli
