// A pose made as exact as the clouds allow, by the iterative closest points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_covariance.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// Which distance between a moved source point x and its nearest target point q is made small.
enum class RefinementMethod : std::uint8_t {
  point,  ///< |x - q| (Besl, McKay, "A method for registration of 3-D shapes", PAMI 1992)
  plane,  ///< n . (x - q), n the target's normal (Chen, Medioni, "Object modelling by registration...", IVC 1992)
  /// Mahalanobis distance with plane-like covariances at both points, 1e-3 along their normals and 1 across (Segal,
  /// Haehnel, Thrun, "Generalized-ICP", RSS 2009).
  gicp,
};

/// "point", "plane", "gicp".
[[nodiscard]] std::string_view to_string(RefinementMethod method) noexcept;

/// Inverse of `to_string`. Throws std::invalid_argument that names the bad value and the accepted ones.
[[nodiscard]] RefinementMethod parse_refinement_method(std::string_view name);

enum class RefinementStatus : std::uint8_t {
  converged,            ///< the last step was too small to matter
  iteration_limit,      ///< steps were still larger after max_iterations
  degenerate_geometry,  ///< the pairs leave a motion free: one plane, a cylinder, a line
  too_few_pairs,        ///< fewer than six source points have a target point within max_distance: no overlap
};

/// "converged", "iteration_limit", ...
[[nodiscard]] std::string_view to_string(RefinementStatus status) noexcept;

struct RefinementOptions {
  RefinementMethod method = RefinementMethod::plane;
  /// Points whose nearest one is further away are no pair; caller's unit, > 0. When not given three times the mean of
  /// the two clouds' resolutions, which is also the noise bound of correspondences.
  std::optional<double> max_distance = std::nullopt;
  std::uint32_t max_iterations = 50;  ///< >= 1
};

struct Refinement {
  RefinementStatus status = RefinementStatus::too_few_pairs;
  /// Refined; along the directions that degenerate pairs leave free as it was at the start.
  RigidTransform T_target_source = RigidTransform::Identity();
  /// What the pose's error has, in the conventions of a Registration's (see pose_covariance.hpp). Zero unless
  /// converged.
  PoseCovariance covariance = PoseCovariance::Zero();
  std::uint32_t iterations = 0;
  std::size_t pairs = 0;        ///< source points with a target point within max_distance, at the end
  double inlier_share = 0.0;    ///< of the source's points
  double rmse = 0.0;            ///< of the pairs: distances to planes with `plane`, else between points; caller's unit
  double residual_scale = 0.0;  ///< robust deviation of what is made small; caller's unit
  double shared_errors = 1.0;   ///< by how much errors shared among neighbours enlarge the covariance
  double max_distance = 0.0;    ///< used
  double seconds = 0.0;

  /// Whether T_target_source is better than the start.
  [[nodiscard]] bool has_pose() const noexcept { return status == RefinementStatus::converged; }
};

/// Refines `start`, which must bring most points of the overlap to within about max_distance of theirs.
///
/// Pairs are each source point and the nearest target point. They are weighted by w = 1 / (1 + (r / (2.385 s))^2), the
/// Cauchy function with its 95 % efficient constant, s from the median of |r|, which was among the best of fourteen
/// robust functions for scans (Babin, Giguere, Pomerleau, "Analysis of robust functions for registration algorithms",
/// ICRA 2019). Steps are Gauss-Newton's, in the directions that the pairs determine (Zhang, Kaess, Singh, "On
/// degeneracy of optimization-based state estimation problems", ICRA 2016).
///
/// The clouds are taken as they are: thinned out by `voxel_grid`, so that all places weigh the same. `plane` needs
/// normals of the target, `gicp` of both; points without one are no pair. In parallel; the same bits for any number of
/// threads and instruction set. Never throws for want of a pose: the status says so. Throws std::invalid_argument on
/// bad options, missing normals, or a start that is not finite.
[[nodiscard]] Refinement refine(const Cloud& source, const Cloud& target, const RigidTransform& start,
                                const RefinementOptions& options = {});

}  // namespace features
}  // namespace consimd
