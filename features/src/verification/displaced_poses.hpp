// Other poses of two clouds that keep what the clouds' large surfaces keep.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

#include "verification/surface_layout.hpp"

namespace consimd::features::detail {

/// Displaces poses in the frame of the target.
class Displacements {
 public:
  /// layout: of the target's surfaces. least: displacements are larger than this, caller's unit.
  Displacements(const SurfaceLayout& layout, double least, std::uint64_t seed);

  /// About `count` poses, as many of each family: for each direction that many surfaces face, shifts across it, with
  /// half a turn about it or without, and turns about it by any angle with such shifts; for each two such directions,
  /// shifts across both. Shifts are as long as the surfaces are spread at most.
  [[nodiscard]] std::vector<RigidTransform> of(const RigidTransform& pose, std::size_t count) const;

 private:
  SurfaceLayout layout_;
  double least_;
  std::uint64_t seed_;
};

}  // namespace consimd::features::detail
