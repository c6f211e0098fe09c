// The data of a comparison.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

#include <consimd/studies/outcome.hpp>
#include <consimd/studies/success_limits.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What a solver is given, and the truth about it.
struct CaseData {
  synth::Problem problem;    ///< is_inlier says which rows an outlier removal should keep
  double noise_bound = 0.0;  ///< largest residual of an inlier
};

/// What the whole pipeline made of two scans.
struct ScanRun {
  Outcome outcome;  ///< its rows are those of the data; its time is that of all stages, from points in memory to pose
  CaseData data;    ///< the matches that the pose was found on
};

/// A registration problem with its truth.
struct Case {
  std::string name;        ///< within its group
  std::uint64_t seed = 1;  ///< of the first run
  /// What counts as a success. None: the root mean square residual of the true inliers must be below the noise bound,
  /// the noise study's measure, unless `displacement` says otherwise.
  std::optional<PoseLimits> limits = {};
  std::optional<DisplacementLimit> displacement = {};
  /// Hash of the files that it is read from; empty where it is made.
  std::string digest = {};
  /// Between the scans, in their unit; NaN where it is not known before the problem is.
  double distance = std::numeric_limits<double>::quiet_NaN();
  /// The problem. May throw what the data's reader throws.
  std::function<CaseData()> load = {};
  /// Registers the scans themselves with a solver and a seed, their own verification included; nothing where there are
  /// no scans.
  std::function<ScanRun(std::string_view solver, std::uint64_t seed)> register_scans = {};
};

/// Cases that stand in one block of a table.
struct CaseGroup {
  std::string name;
  std::string provenance = {};  ///< what the data are: real files, or which kind of synthetic stand-in
  std::vector<Case> cases = {};
  std::vector<std::string> methods = {};  ///< what runs on them, see method.hpp
};

/// A group for every named sequence (see synth::stand_ins): `pairs` pairs of scans, success limits of `preset`, "case"
/// meaning the paper's. Throws std::invalid_argument on an unknown name or preset.
[[nodiscard]] std::vector<CaseGroup> stand_in_groups(const std::vector<std::string>& names, std::uint32_t pairs,
                                                     std::uint64_t seed, std::string_view preset);

struct NoiseCells {
  std::size_t points = 3000;
  std::vector<double> outlier_ratios;
  std::vector<double> sigmas;
  std::uint32_t trials = 20;
  std::uint64_t seed = 1;
  double scale = 1.0;  ///< of the source: its points are divided by it
};

/// A group for every outlier ratio with the trials of all noise levels: the same problems as those of the noise study.
/// Throws std::invalid_argument on values that the noise study would refuse.
[[nodiscard]] std::vector<CaseGroup> noise_groups(const NoiseCells& cells);

}  // namespace studies
}  // namespace consimd
