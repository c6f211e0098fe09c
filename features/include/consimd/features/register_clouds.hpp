// From two clouds to a pose in one call.
#pragma once

#include <optional>
#include <string>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/cloud_verdict.hpp>
#include <consimd/features/refinement.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/solver.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct CloudRegistrationOptions {
  CloudMatchingOptions matching = {};
  /// Largest residual of an inlier, caller's unit; from the clouds' resolution when not given.
  std::optional<double> noise_bound = std::nullopt;
  /// A solver's name, with options if need be: see SolverChoice.
  std::string solver = "tcf";
  Filter filter = Filter::none;
  std::uint64_t seed = 1;
  /// At most so many threads, in an oneTBB arena of its own; 0: in the caller's arena.
  int threads = 0;
  StopCondition stop = {};  ///< ends the search among the matches early; there is no further attempt then
  /// Let the clouds decide over the pose of their correspondences (see cloud_verdict.hpp). Where they leave it in doubt
  /// the front end is tried once more with voxels of one and a half times the side, and where they bear none out up to
  /// three times, each with voxels at least that much larger. A pose of larger voxels is refined on them, point to
  /// plane; inliers and what the clouds said stay those of the pose before.
  bool verify = true;
  /// How the pose is refined on the clouds, if at all (see refinement.hpp).
  std::optional<RefinementMethod> refine = std::nullopt;
};

struct CloudRegistration {
  CloudMatches matches;
  Registration registration;  ///< inliers are rows of matches.correspondences
  /// Where the clouds were to decide.
  std::optional<CloudVerdict> verdict = std::nullopt;
  /// How often the front end was tried. All else is of the attempt whose pose is least likely by chance; where none is
  /// borne out it is of the first, or of one that shows that the scene repeats itself or that the clouds are of two
  /// scales.
  std::size_t attempts = 1;
  /// Where it was asked for and there was a pose to start from.
  std::optional<Refinement> refinement = std::nullopt;
};

/// Verifies a registration of `matches`, made of these clouds, and lets them decide: `decide` with a `PoseVerifier` of
/// their voxels, see cloud_verdict.hpp. Of `options` it takes viewpoints and seed. `matches` must have the voxels that
/// `match_clouds` leaves in it. A registration without a pose and without a refused one stays as it is, and only the
/// status of the verdict is told. A pose that the clouds led to is refined on them, point to plane, which gives its
/// covariance and the stage "refine". `led_to_before`: CloudVerdict::led_to of another attempt. Throws
/// std::invalid_argument on a viewpoint that is not finite, and as `decide`.
CloudVerdict verify_registration(const Cloud& source, const Cloud& target, const CloudMatches& matches,
                                 const CloudMatchingOptions& options, Registration& registration,
                                 const std::optional<RigidTransform>& led_to_before = std::nullopt);

/// Refines the pose of a registration, caller's frames and unit, on the voxels of its clouds, within its noise bound.
/// Where that converges the registration gets the refined pose and its covariance; status, inliers and significance
/// stay those of the correspondences. Adds the stage "refine": source voxels, pairs, iterations. The registration must
/// have a pose: this is not checked, and without one the identity would be refined. `matches` must have the voxels that
/// `match_clouds` leaves in it. Throws std::invalid_argument as `refine`: on a noise bound that is not a finite length
/// above 0, on voxels without the normals that the method needs, or on a pose that is not finite.
Refinement refine_registration(const CloudMatches& matches, RefinementMethod method, Registration& registration);

/// `match_clouds`, then `register_by_name`, then `verify_registration`, then, if asked for, `refine_registration`.
/// Throws std::invalid_argument as these do.
[[nodiscard]] CloudRegistration register_clouds(const Cloud& source, const Cloud& target,
                                                const CloudRegistrationOptions& options = {});

}  // namespace features
}  // namespace consimd
