// Other poses of two clouds that keep what the clouds' large surfaces keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

#include "verification/observed_space.hpp"

namespace consimd::features::detail {

/// Displaces poses in the frame of the target.
class Displacements {
 public:
  /// surfaces: of the target. least: displacements are larger than this, caller's unit. At least one point.
  Displacements(const std::vector<SurfacePoint>& surfaces, double least, std::uint64_t seed);

  /// About `count` poses, as many of each family: for each direction that many surfaces face, shifts across it, with
  /// half a turn about it or without, and turns about it by any angle with such shifts; for each two such directions,
  /// shifts across both. Shifts are as long as the surfaces are spread at most.
  [[nodiscard]] std::vector<RigidTransform> of(const RigidTransform& pose, std::size_t count) const;

 private:
  std::vector<Eigen::Vector3d> directions_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  double spread_ = 0.0;  // root mean square distance of the surfaces from their centre
  double least_;
  std::uint64_t seed_;
};

}  // namespace consimd::features::detail
