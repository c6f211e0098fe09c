// Fits a pose of one cloud to the surfaces of another.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

#include "verification/observed_space.hpp"
#include "verification/surface_layout.hpp"

namespace consimd::features::detail {

/// x_target = R (scale x_source) + t.
struct ScaledPose {
  RigidTransform T_target_source = RigidTransform::Identity();
  double scale = 1.0;
};

/// A surface point where a pose takes it.
[[nodiscard]] inline SurfacePoint placed(const ScaledPose& pose, const SurfacePoint& surface) {
  const RigidTransform& rigid = pose.T_target_source;
  const Eigen::Vector3d point = rigid.linear() * (pose.scale * vector(surface.point)) + rigid.translation();
  const Eigen::Vector3d normal = rigid.linear() * vector(surface.normal);
  return {{point.x(), point.y(), point.z()}, {normal.x(), normal.y(), normal.z()}, surface.has_front};
}

/// What a fit may change.
enum class Freedom : std::uint8_t { rigid, scaled };

/// The surfaces that poses are fitted to.
struct FittedSurfaces {
  const SurfaceMap& coarse;  ///< in cubes of some voxels
  const SurfaceMap& fine;    ///< in cubes of one voxel
  const SurfaceLayout& layout;
  double voxel;
};

/// The pose near `start` at which the samples agree best with the surfaces, by least squares to their planes (Chen &
/// Medioni 1991), to the coarse ones first. What no plane determines moves little.
[[nodiscard]] ScaledPose fitted(const FittedSurfaces& target, const std::vector<SurfacePoint>& samples,
                                const RigidTransform& start, Freedom freedom);

}  // namespace consimd::features::detail
