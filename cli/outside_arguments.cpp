#include "outside_arguments.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "interruption.hpp"
#include "solver_arguments.hpp"
#include "standard_streams.hpp"

namespace consimd::cli {
namespace {

/// The solvers of one argument: names up to the first program, whose command may have commas.
std::vector<std::string> split(std::string_view argument) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t comma = argument.find(',');
    if (argument.find('=') < comma && studies::parse_outside_program(argument)) {
      parts.emplace_back(argument);
      return parts;
    }
    parts.emplace_back(argument.substr(0, comma));
    if (comma == std::string_view::npos) return parts;
    argument.remove_prefix(comma + 1);
  }
}

/// Gives the programs their versions.
void set_versions(const std::vector<std::string>& versions, std::vector<studies::OutsideProgram>& programs) {
  for (const std::string& text : versions) {
    const std::size_t end = text.find('=');
    const auto program =
        std::ranges::find(programs, std::string_view(text).substr(0, end), &studies::OutsideProgram::name);
    if (end == std::string::npos || end + 1 == text.size() || program == programs.end()) {
      throw std::invalid_argument(
          fmt::format("--solver-version: expected NAME=TEXT with the name of a program in --solver, got '{}'", text));
    }
    if (!program->version.empty()) {
      throw std::invalid_argument(fmt::format("--solver-version: {} has two, '{}' and '{}'", program->name,
                                              program->version, text.substr(end + 1)));
    }
    program->version = text.substr(end + 1);
  }
}

}  // namespace

void add_solver_arguments(CLI::App& command, SolverArguments& arguments) {
  command
      .add_option("--solver", arguments.solvers,
                  "Solvers, separated by commas, each " + solver_help() +
                      ". NAME=exec:COMMAND is a program of yours, with the rest of the argument as its command; "
                      "exec-binary: gives it numbers in binary")
      ->capture_default_str();
  add_option_setting(command, arguments.settings);
  command
      .add_option("--time-limit", arguments.time_limit,
                  "Seconds that a program in --solver has for a problem, and to get ready; a slower one is killed, and "
                  "the problem counts as failed. An error without a program: consimd's own solvers have budgets")
      ->default_str(fmt::format("{}", studies::kDefaultTimeLimit));
  command
      .add_option("--solver-version", arguments.versions,
                  "NAME=TEXT, the version of a program in --solver, in place of what it tells; as often as needed")
      ->allow_extra_args(false);
}

StudySolvers solvers_of(const SolverArguments& arguments) {
  StudySolvers solvers;
  std::vector<studies::OutsideProgram> programs;
  studies::OutsideSolvers named;
  for (const std::string& argument : arguments.solvers) {
    for (const std::string& solver : split(argument)) {
      if (std::optional<studies::OutsideProgram> program = studies::parse_outside_program(solver)) {
        program->time_limit = arguments.time_limit.value_or(studies::kDefaultTimeLimit);
        solvers.names.push_back(program->name);
        named.push_back({.name = program->name});
        programs.push_back(std::move(*program));
      } else {
        solvers.names.push_back(choice_of(solver, arguments.settings).label());
      }
    }
  }
  if (!arguments.settings.empty() && programs.size() == solvers.names.size()) {
    throw std::invalid_argument(
        fmt::format("--option: '{}' is of no solver of consimd, and --solver names none", arguments.settings.front()));
  }
  if (arguments.time_limit && programs.empty()) {
    throw std::invalid_argument(fmt::format(
        "--time-limit: {} s are for programs, NAME=exec:COMMAND, and --solver names none", *arguments.time_limit));
  }
  set_versions(arguments.versions, programs);
  studies::require_outside_solvers(named, solvers.names);  // before any starts: a program takes its time
  for (studies::OutsideProgram& program : programs) {
    program.stop_requested = [] { return InterruptionGuard::requested(); };
    solvers.outside.push_back(start_outside_program(program));
  }
  return solvers;
}

void FailureReport::tell_all(std::string_view steps) const {
  if (count_ == 0) return;
  tell("consimd: programs failed in {} {}, first {}\n", count_, steps, first_);
}

}  // namespace consimd::cli
