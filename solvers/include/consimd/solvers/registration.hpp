// What every solver returns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <consimd/kernels/export.hpp>
#include <consimd/kernels/isa.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

namespace CONSIMD_EXPORT consimd {

/// Why a solver stopped.
enum class Status : std::uint8_t {
  success,                  ///< a pose with significant support
  too_few_correspondences,  ///< fewer than three, copies and rows far from all others not counted
  no_consensus,             ///< no pose has more support than chance gives
  degenerate_geometry,      ///< the supporters do not determine a pose: coincident, or on a line
  ambiguous,                ///< another motion has about as much support, or a pose near one that nothing refined has
                            ///< more; see Registration::runner_up
  budget_exhausted,         ///< the search ended before the wanted confidence: by its budget, or stopped
};

/// "success", "too_few_correspondences", ...
[[nodiscard]] std::string_view to_string(Status status) noexcept;

/// One stage of a solver.
struct StageReport {
  std::string name;
  std::size_t input = 0;         ///< correspondences given to the stage
  std::size_t output = 0;        ///< correspondences it kept
  std::uint64_t iterations = 0;  ///< hypotheses drawn, or rounds
  double seconds = 0.0;
};

/// A pose that is not the one returned.
struct RunnerUp {
  RigidTransform T_target_source = RigidTransform::Identity();
  std::size_t support = 0;         ///< correspondences within the noise bound of it
  double log10_false_poses = 0.0;  ///< as in Registration
  double scale = 1.0;              ///< as in Registration
};

struct Registration {
  Status status = Status::no_consensus;
  /// Maps source points, multiplied by `scale`, to the target frame: x_target = R (scale * x_source) + t, in the
  /// caller's units. A rigid motion whatever the scale is. The identity unless status is success, ambiguous or
  /// budget_exhausted.
  RigidTransform T_target_source = RigidTransform::Identity();
  /// The scale of the source, 1 where it is known (see SolverOptions::estimate_scale).
  double scale = 1.0;
  /// Standard deviation of `scale`; 0 where it is known, and from teaser without refinement.
  double scale_deviation = 0.0;
  /// Covariance of the pose's error (theta, dt), rotation in rad before translation in the caller's unit, target frame
  /// (see pose_covariance.hpp), for a pose near the true one; the significance tells whether it is. Zero when there is
  /// no pose, and from tcf-published and teaser without refinement, which do not estimate it. Where the scale was
  /// estimated dt also holds what the scale's error adds at the source's origin.
  PoseCovariance covariance = PoseCovariance::Zero();
  /// Rows within `noise_bound` of the pose, ascending, copies of one another included. Empty when there is no pose.
  std::vector<std::uint32_t> inliers;
  /// log10 of an upper bound on the number of equally supported poses expected by chance (see significance.hpp).
  /// Success needs it below the solver's limit; at -4.5 or below a glance may have told it, which asks no more: the
  /// same pose may have -5 or -50. `significance` at Scrutiny::close tells it closely, but for the factor of bounds
  /// that were tried. Without a pose it is that of the best one met, 0 where none was.
  double log10_false_poses = 0.0;
  /// The best pose of another motion that the search met, where it is significant. One with four fifths of the support
  /// is met nearly as surely as the best pose. Two rigid motions, or an object that is its own image when turned, show
  /// here. Of two clouds it may be a pose at which these agree as well, with few rows (see cloud_verdict.hpp). Of
  /// tcf-published and of teaser without refinement it may be a pose near theirs, with more than five fourths of its
  /// supporters.
  std::optional<RunnerUp> runner_up;
  /// Without a pose: the most significant one that was met, which chance or structure gives as well; for those who have
  /// other evidence. None where it is a mirror image, at another scale, distorted or undetermined.
  std::optional<RunnerUp> refused;
  /// Without a pose: the rows that agree in length are a mirror image, which no motion brings into place.
  bool mirrored = false;
  /// The search was ended by its StopCondition: a pose is the best until then, and none may yet have been found.
  bool stopped = false;
  std::vector<StageReport> stages;
  double seconds = 0.0;  ///< wall time of the whole registration

  // What was used.
  std::uint64_t seed = 0;
  Isa isa = Isa::scalar;
  int threads = 1;           ///< concurrency of the arena
  double noise_bound = 0.0;  ///< tau, caller's unit
  /// What was given, or estimated where nothing was. `noise_bound` is larger where this is below the resolution of the
  /// data (see Correspondences::resolution).
  double noise_bound_asked = 0.0;
  double consistency_bound = 0.0;  ///< bound on pairwise length differences, 2 tau

  [[nodiscard]] bool has_pose() const noexcept {
    return status == Status::success || status == Status::ambiguous || status == Status::budget_exhausted;
  }
};
static_assert(alignof(Registration) == alignof(double));

}  // namespace consimd
