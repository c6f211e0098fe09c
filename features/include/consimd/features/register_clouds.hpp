// From two clouds to a pose in one call.
#pragma once

#include <optional>
#include <string>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct CloudRegistrationOptions {
  CloudMatchingOptions matching = {};
  /// Largest residual of an inlier, caller's unit; from the clouds' resolution when not given.
  std::optional<double> noise_bound = std::nullopt;
  /// A solver's name, with options if need be: see SolverChoice.
  std::string solver = "tcf";
  std::uint64_t seed = 1;
};

struct CloudRegistration {
  CloudMatches matches;
  Registration registration;  ///< inliers are rows of matches.correspondences
};

/// `match_clouds`, then `register_by_name`. Throws std::invalid_argument as these do.
[[nodiscard]] CloudRegistration register_clouds(const Cloud& source, const Cloud& target,
                                                const CloudRegistrationOptions& options = {});

}  // namespace features
}  // namespace consimd
