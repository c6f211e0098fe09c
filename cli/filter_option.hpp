// The filter before a solver, as an option.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace consimd::cli {

/// The name goes through `filter_by_name` when the command runs.
inline void add_filter_option(CLI::App& command, std::string& filter) {
  command
      .add_option(
          "--filter", filter,
          "Give the solver only what this keeps of the correspondences: tcf (one- and two-point RANSAC), or none. "
          "The pose is refined and tested on all of them")
      ->capture_default_str();
}

}  // namespace consimd::cli
