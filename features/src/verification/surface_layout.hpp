// How the surfaces of a cloud lie: what its poses are displaced about.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <consimd/poses/rigid_fit.hpp>

#include "verification/observed_space.hpp"

namespace consimd::features::detail {

struct SurfaceLayout {
  /// Directions that at least a twentieth of the normals lie within 15 degrees of, either way, the largest first; the
  /// axes of the frame where there are none.
  std::vector<Eigen::Vector3d> faced;
  /// Principal axes of the points that are none of those directions.
  std::vector<Eigen::Vector3d> principal;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< mean of the points
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();  ///< mean of (x - centre) (x - centre)^T
  double spread = 0.0;                                ///< root mean square distance of the points from their centre
};

/// surfaces: all of them, whose points tell where the middle and the axes are; samples: some of them, whose normals
/// tell the directions. Without any the layout is that of no point. Deterministic in the seed.
[[nodiscard]] SurfaceLayout layout_of(std::span<const SurfacePoint> surfaces, const std::vector<SurfacePoint>& samples,
                                      std::uint64_t seed);

/// The pose with what it places turned about the line through `centre` along `axis`, a unit vector, by the angle of
/// this cosine and sine (Rodrigues).
[[nodiscard]] RigidTransform turned_about(const Eigen::Vector3d& centre, const Eigen::Vector3d& axis, double cosine,
                                          double sine, const RigidTransform& pose);

}  // namespace consimd::features::detail
