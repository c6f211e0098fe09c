#include "solver_arguments.hpp"

#include <stdexcept>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace consimd::cli {

std::string solver_help() {
  return fmt::format("one of {}. NAME:OPTION=VALUE:... sets options, which 'consimd info --solver NAME' lists",
                     fmt::join(solver_names(), ", "));
}

std::string scale_solvers() {
  std::vector<std::string> names;
  for (const Solver& solver : solvers()) {
    if (solver.estimates_scale()) names.push_back(solver.name);
  }
  return fmt::format("{}", fmt::join(names, " or "));
}

void add_option_setting(CLI::App& command, std::vector<std::string>& settings) {
  command
      .add_option("--option", settings,
                  "NAME=VALUE, an option of the solver, or of every solver given; as often as needed. 'consimd info "
                  "--solver NAME' lists the options")
      ->allow_extra_args(false);
}

SolverChoice choice_of(const std::string& text, const std::vector<std::string>& settings) {
  SolverChoice choice(text);
  for (const std::string& setting : settings) {
    try {
      choice.set(setting);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("--option: {}", error.what()));
    }
  }
  return choice;
}

}  // namespace consimd::cli
