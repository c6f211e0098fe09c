// What a noise study runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/solvers/solver.hpp>
#include <consimd/studies/outside_solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// The noise study of the TCF paper, as `parse_value_list` reads it.
inline constexpr std::string_view kPaperOutlierRatios = "0.1,0.5,0.9,0.95,0.98";
inline constexpr std::string_view kPaperSigmas = "0.1:5:50";

/// Defaults: the paper's study.
struct SweepOptions {
  std::size_t points = 3000;                   ///< correspondences of a problem
  std::vector<double> outlier_ratios;          ///< in [0, 1)
  std::vector<double> sigmas;                  ///< standard deviations of the inliers' noise, metres, > 0
  std::uint32_t trials = 100;                  ///< problems per outlier ratio and noise level
  std::vector<std::string> solvers = {"tcf"};  ///< as SolverChoice takes them, or names of outside solvers
  OutsideSolvers outside = {};                 ///< those that `solvers` names
  Filter filter = Filter::none;                ///< before every solver
  std::uint64_t seed = 1;                      ///< of the data; trial k runs its solvers with seed + k

  SweepOptions();

  [[nodiscard]] std::size_t cells() const noexcept { return solvers.size() * outlier_ratios.size() * sigmas.size(); }
};

/// Throws std::invalid_argument on the first bad value: an empty or repeated list entry, a value out of range, an
/// outlier ratio that leaves fewer than three inliers, an unknown solver, a bad option of one, an outside solver that
/// `require_outside_solvers` refuses or the list lacks.
void validate(const SweepOptions& options);

}  // namespace studies
}  // namespace consimd
