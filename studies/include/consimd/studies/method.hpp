// What a comparison runs, by name.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// What a method made of a problem.
struct Outcome {
  std::string status;  ///< a solver's, or "pose", "no_pose" or "rows" (a set without a pose) of stages
  bool has_pose = false;
  RigidTransform T_target_source = RigidTransform::Identity();  ///< of the scaled source
  double scale = 1.0;                                           ///< of the source
  std::vector<std::uint32_t> kept = {};  ///< rows left in the end: a pose's inliers, or what the last stage let through
  double seconds = 0.0;
};

/// A method is named
///   "ransac"              a solver, as SolverChoice takes it: options may follow, "ransac:max_iterations=1000"
///   "tcf+ransac"          a solver after TCF's filter
///   "scale+teaser"        a solver that finds the scale of the source as well
///   "1R+3R+IRLS"          stages of TCF with their defaults, one after the other on what the last one kept: one-, two-
///                         and three-point RANSAC, scale-adaptive Cauchy IRLS. 3R and IRLS give a pose
///   "plain-ransac-10000"  three-point RANSAC of as many samples, neither stopped early nor locally optimised; a length
///                         check, which no sample of inliers fails, spares it fits
/// Throws std::invalid_argument on another name.
[[nodiscard]] Outcome run_method(std::string_view name, const Correspondences& correspondences, double noise_bound,
                                 std::uint64_t seed);

/// The values of all options, defaults included, of the solver that a method runs; empty for stages and plain RANSAC.
/// Throws as above.
[[nodiscard]] std::string option_values(std::string_view name);

/// The names above, put together.
[[nodiscard]] std::string after_filter(std::string_view solver);
[[nodiscard]] std::string with_scale(std::string_view solver);
[[nodiscard]] std::string plain_ransac(std::uint32_t iterations);

}  // namespace studies
}  // namespace consimd
