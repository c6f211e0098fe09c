// Solvers and their options on the command line.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/solvers/registry.hpp>

namespace consimd::cli {

/// What --solver takes, for its help: the names there are, and how to set options.
[[nodiscard]] std::string solver_help();

/// The names of the solvers that find the scale of the source, for help.
[[nodiscard]] std::string scale_solvers();

/// --option NAME=VALUE, as often as one likes.
void add_option_setting(CLI::App& command, std::vector<std::string>& settings);

/// The solver that `text` names with the options that it and `settings` set. Throws std::invalid_argument on what the
/// solver does not have, and on options set twice.
[[nodiscard]] SolverChoice choice_of(const std::string& text, const std::vector<std::string>& settings);

}  // namespace consimd::cli
