// What a noise study runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/studies/condition.hpp>
#include <consimd/studies/outside_solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The noise study of the TCF paper, as `parse_value_list` reads it.
inline constexpr std::string_view kPaperOutlierRatios = "0.1,0.5,0.9,0.95,0.98";
inline constexpr std::string_view kPaperSigmas = "0.1:5:50";

/// Defaults: the paper's study. Every value of a list meets every one of the others.
struct SweepOptions {
  std::vector<std::size_t> points = {3000};    ///< correspondences of a problem
  std::vector<double> outlier_ratios;          ///< in [0, 1)
  std::vector<double> sigmas;                  ///< standard deviations of the inliers' noise, metres, > 0
  std::uint32_t trials = 100;                  ///< problems of a cell
  std::vector<std::string> solvers = {"tcf"};  ///< as SolverChoice takes them, or names of outside solvers
  OutsideSolvers outside = {};                 ///< those that `solvers` names
  Filter filter = Filter::none;                ///< before every solver
  std::uint64_t seed = 1;                      ///< of the data; trial k runs its solvers with seed + k

  std::vector<std::string> families = {"gaussian"};  ///< see consimd/synth/problem_families.hpp
  std::vector<ScaleKnowledge> scales = {ScaleKnowledge::known};
  std::vector<BoundFactor> bound_factors = {1.0};
  /// Share of a cell's problems that have no true pose, in [0, 1), evenly spread over its trials.
  double no_pose = 0.0;

  SweepOptions();

  /// Whether families, scales, numbers of points, bound factors or problems without a pose go beyond what the paper
  /// varies: the study's tables then have the columns that tell of them.
  [[nodiscard]] bool beyond_paper() const;

  /// All that the cells of one solver, outlier ratio and noise level differ in, the family outermost and the bound
  /// factor innermost.
  [[nodiscard]] std::vector<Condition> conditions() const;

  /// Whether trial k of a cell has a true pose; the first has.
  [[nodiscard]] bool has_true_pose(std::uint32_t trial) const;

  /// Over all conditions.
  [[nodiscard]] std::size_t cells() const noexcept {
    return solvers.size() * families.size() * scales.size() * points.size() * bound_factors.size() *
           outlier_ratios.size() * sigmas.size();
  }
};

/// Throws std::invalid_argument on the first bad value: an empty or repeated list entry, a value out of range, an
/// outlier ratio that leaves fewer than three inliers, an unknown family or solver, a bad option of one, an outside
/// solver that `require_outside_solvers` refuses or the list lacks, and an unknown scale with a solver that does not
/// find it, a filter or an estimated noise bound.
void validate(const SweepOptions& options);

}  // namespace studies
}  // namespace consimd
