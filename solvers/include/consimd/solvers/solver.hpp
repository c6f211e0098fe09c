// All solvers behind one call: what the command line and the noise study use.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/point_pairs.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/registry.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace CONSIMD_EXPORT consimd {

/// What selects the correspondences that a solver is given.
enum class Filter : std::uint8_t {
  none,  ///< all of them
  tcf,   ///< the two filters of TCF, see tcf_filter.hpp
};

/// "none", "tcf".
[[nodiscard]] std::string_view to_string(Filter filter) noexcept;

/// Inverse of `to_string`. Throws std::invalid_argument on an unknown name, listing the known ones.
[[nodiscard]] Filter filter_by_name(std::string_view name);

/// Options that every solver has.
struct SolverOptions {
  /// Largest residual of an inlier, caller's unit; finite and > 0. Estimated from the correspondences when not given
  /// (see noise_bound.hpp); Registration::noise_bound tells what was used.
  std::optional<double> noise_bound = std::nullopt;
  std::uint64_t seed = 1;
  Filter filter = Filter::none;
  /// Find the scale of the source as well: x_target = scale * R * x_source + t. Only of solvers that can,
  /// with a noise bound and without a filter. The same as their option of that name.
  bool estimate_scale = false;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search early
};

/// Runs a solver, after the filter if there is one. A pose found among the rows that a filter keeps is brought
/// into place, tested and given its inliers on all rows: it counts as if it had been searched for among all of them, so
/// that the choice which the filter made cannot make it look significant. The stages of the filter, those of the solver
/// on what it kept, and a last one, "all_rows", are reported. Where there is no pose and rows recur, those that tell of
/// different places are registered by themselves, and the pose is brought to all rows. Throws std::invalid_argument on
/// a bad option, or on estimate_scale where it cannot be.
[[nodiscard]] Registration register_by_choice(SolverChoice choice, const Correspondences& correspondences,
                                              SolverOptions options);

/// As above with `SolverChoice(solver)`: a name, or a name with options. Throws std::invalid_argument on an unknown
/// name, listing the known ones.
[[nodiscard]] Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                                            const SolverOptions& options);

/// The same where source[k] is to be brought to target[k]: see point_pairs.hpp.
template <typename Source, typename Target>
[[nodiscard]] Registration register_by_name(std::string_view solver, const Source& source, const Target& target,
                                            const SolverOptions& options) {
  return register_by_name(solver, point_pairs(source, target), options);
}

/// A solver of the caller's, called in the arena of the options with the noise bound to use, which was chosen from
/// `bounds_tried` ones by looking at the data. Without a bound it may be called again, with some of the rows, where all
/// of them have told nothing.
using SolverCall = std::function<Registration(const Correspondences&, double noise_bound, std::uint32_t bounds_tried)>;

/// As above for a solver of the caller's, which has its own seed; that of `options` is for the rest.
[[nodiscard]] Registration register_with(const SolverCall& solver, const Correspondences& correspondences,
                                         const SolverOptions& options);

}  // namespace consimd
