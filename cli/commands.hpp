// The subcommands of `consimd`: each adds itself to the parser and sets `run` when it is chosen.
#pragma once

#include <functional>

#include <CLI/CLI.hpp>

namespace consimd::cli {

/// Exit codes.
inline constexpr int kSuccess = 0;
inline constexpr int kNoPose = 1;         ///< a registration found no pose
inline constexpr int kBadInput = 2;       ///< bad usage, bad input, or a file or output that cannot be written
inline constexpr int kInterrupted = 130;  ///< stopped by a signal

/// What the chosen subcommand does; returns the exit code, throws what goes to stderr in one line.
using Action = std::function<int()>;

void add_register_command(CLI::App& app, Action& run);
void add_match_command(CLI::App& app, Action& run);
void add_compare_command(CLI::App& app, Action& run);
void add_sweep_command(CLI::App& app, Action& run);
void add_merge_command(CLI::App& app, Action& run);
void add_generate_command(CLI::App& app, Action& run);
void add_info_command(CLI::App& app, Action& run);

}  // namespace consimd::cli
