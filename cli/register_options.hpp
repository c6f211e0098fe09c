// What `consimd register` is told.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <consimd/solvers/solver.hpp>

#include "cloud_arguments.hpp"

namespace consimd::cli {

struct RegisterOptions {
  std::string file;
  std::string target;  ///< of two clouds; empty: `file` holds correspondences
  std::string pairs;   ///< of two clouds whose points are matched already: "rows", or a file
  CloudArguments clouds;
  std::optional<double> noise_bound;
  std::string solver = solvers().front().name;
  std::vector<std::string> settings;
  std::string filter{to_string(SolverOptions().filter)};
  bool estimate_scale = false;
  std::uint64_t seed = SolverOptions().seed;
  std::uint32_t repeat = 1;
  int threads = 1;
  std::optional<double> time_limit;
  bool assume_inliers = false;
  std::string truth;
  std::string json;
  std::string save_pose;
  std::string save_inliers;
  std::string view;
  std::string picture;

  /// Whether there are two clouds to be matched.
  [[nodiscard]] bool matches_clouds() const { return !target.empty() && pairs.empty(); }
  /// Whether the standard output is for people: no result of one kind was sent there alone.
  [[nodiscard]] bool prints_report() const { return json.empty() && save_pose != "-" && save_inliers != "-"; }
};

void add_register_options(CLI::App& command, RegisterOptions& options);

/// Throws std::invalid_argument that names the option where one is wrong or does not go with another, and
/// std::runtime_error that names the file where one cannot be written.
void check(const RegisterOptions& options);

}  // namespace consimd::cli
