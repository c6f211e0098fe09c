// All solvers behind one call, by name: what the command line and the noise study use.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {

struct SolverInfo {
  std::string_view name;         ///< "tcf"
  std::string_view description;  ///< one line
};

/// Every solver of this build, the default first.
[[nodiscard]] std::span<const SolverInfo> solvers() noexcept;

/// Options that every solver has; the rest are its own defaults.
struct SolverOptions {
  /// Largest residual of an inlier, caller's unit; finite and > 0. Estimated from the correspondences when not given
  /// (see noise_bound.hpp); Registration::noise_bound tells what was used.
  std::optional<double> noise_bound = std::nullopt;
  std::uint64_t seed = 1;
};

/// Runs the named solver. Throws std::invalid_argument on an unknown name (listing the known ones) or a bad option.
[[nodiscard]] Registration register_by_name(std::string_view solver, const Correspondences& correspondences,
                                            const SolverOptions& options);

}  // namespace consimd
