// What `consimd register` tells of its runs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/cloud_verdict.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/solver.hpp>

#include "cloud_arguments.hpp"

namespace consimd::cli {

/// A run's errors against the ground truth; degrees, and the file's unit.
struct PoseErrors {
  double rotation_deg = 0.0;
  double translation = 0.0;
  double scale = 0.0;  ///< relative
};

struct RegisterReport {
  std::string file;
  std::optional<features::CloudMatches> clouds = {};  ///< what `file` and another were matched to
  CloudArguments cloud_arguments = {};                ///< as given, of clouds
  Viewpoint row_viewpoint = {};                       ///< of the source of correspondences, if it was given
  std::size_t correspondences = 0;
  std::string isa;
  int threads = 1;
  std::string solver;
  std::vector<OptionSetting> options = {};  ///< of the solver, as given
  Filter filter = Filter::none;
  bool estimate_scale = false;
  std::optional<double> noise_bound = {};  ///< none: estimated in each run
  std::vector<Registration> runs = {};
  std::vector<std::optional<features::Refinement>> refinements = {};  ///< one per run, or none that was not asked for
  /// What two clouds made of each run; none without clouds, or where they were not asked.
  std::vector<features::CloudVerdict> verdicts = {};
  std::vector<std::size_t> attempts = {};  ///< of the front end in each run; none without clouds
  std::vector<PoseErrors> errors = {};     ///< one per run, or none without a ground truth
  /// More rows are supported by the inverse of the given ground truth than by itself.
  bool truth_inverted = false;
  /// Sentences for people (see advice.hpp), of the first run that has any.
  std::vector<std::string> notes = {};
  bool assumed_inliers = false;        ///< nothing was searched: the one run is the least-squares pose of all rows
  std::vector<double> residuals = {};  ///< of each row; with assumed_inliers only
  double sigma = 0.0;                  ///< deviation of a residual per axis; with assumed_inliers only
};

/// One JSON object, a line per run. Numbers read back to the same bits; results that are the same give the same bytes
/// but for times, threads and ISA.
[[nodiscard]] std::string to_json(const RegisterReport& report);

/// For people: the run in full, or a summary of several.
[[nodiscard]] std::string to_text(const RegisterReport& report);

}  // namespace consimd::cli
