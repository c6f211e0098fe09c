// Families of problems on the command line, with all else that a study varies beside outlier ratio and noise.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/studies/sweep_options.hpp>

namespace consimd::cli {

/// What --points, --family, --scale, --bound-factor and --no-pose say: lists, but for the last.
struct ConditionArguments {
  std::string points = "3000";
  std::string families = "gaussian";
  std::string scales = "known";
  std::string bound_factors = "1";
  double no_pose = 0.0;
};

void add_condition_arguments(CLI::App& command, ConditionArguments& arguments);

/// Throws std::invalid_argument that names the option on a bad value.
void set_conditions(studies::SweepOptions& study, const ConditionArguments& arguments);

/// A line per family for the end of a help text.
[[nodiscard]] std::string family_lines();

/// What a study varies, for its first line: "noise bound 3 sigma".
[[nodiscard]] std::string bound_text(const studies::SweepOptions& study);

}  // namespace consimd::cli
