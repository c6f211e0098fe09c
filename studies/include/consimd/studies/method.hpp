// What a comparison runs, by name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/studies/outcome.hpp>
#include <consimd/studies/outside_solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A method is named
///   "ransac"              a solver, as SolverChoice takes it: options may follow, "ransac:max_iterations=1000"
///   "tcf+ransac"          a solver after TCF's filter
///   "scale+teaser"        a solver that finds the scale of the source as well
///   "1R+3R+IRLS"          stages of TCF with their defaults, one after the other on what the last one kept: one-, two-
///                         and three-point RANSAC, scale-adaptive Cauchy IRLS. 3R and IRLS give a pose
///   "plain-ransac-10000"  three-point RANSAC of as many samples, neither stopped early nor locally optimised; a length
///                         check, which no sample of inliers fails, spares it fits
/// Throws std::invalid_argument on another name. That of the pipeline runs on scans, not on correspondences: see
/// `Case::register_scans`.
[[nodiscard]] Outcome run_method(std::string_view name, const Correspondences& correspondences, double noise_bound,
                                 std::uint64_t seed);

/// Whether it is one of the last two: these names are taken.
[[nodiscard]] bool is_method_of_stages(std::string_view name);

/// Whether it is of stages none of which gives a pose.
[[nodiscard]] bool gives_rows_alone(std::string_view name);

/// A method that runs an outside solver: its name, after TCF's filter or not.
struct OutsideMethod {
  const OutsideSolver* solver;
  Filter filter;
};

/// None if the method runs no solver of `outside`.
[[nodiscard]] std::optional<OutsideMethod> outside_method(const OutsideSolvers& outside, std::string_view name);

/// The solver of a method that is the whole pipeline, from scans to a verified pose: "scans+tcf". None of another.
[[nodiscard]] std::optional<std::string_view> pipeline_solver(std::string_view name) noexcept;

/// The values of all options, defaults included, of the solver that a method runs; empty for stages and plain RANSAC.
/// Throws as above.
[[nodiscard]] std::string option_values(std::string_view name);

/// The names above, put together.
[[nodiscard]] std::string after_filter(std::string_view solver);
[[nodiscard]] std::string with_scale(std::string_view solver);
[[nodiscard]] std::string from_scans(std::string_view solver);
[[nodiscard]] std::string plain_ransac(std::uint32_t iterations);

}  // namespace studies
}  // namespace consimd
