// Other poses at which two clouds may agree about as well: the places to which a scene repeats itself.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <consimd/poses/rigid_fit.hpp>

#include "verification/observed_space.hpp"
#include "verification/surface_layout.hpp"

namespace consimd::features::detail {

/// Looks for the peaks of the clouds' agreement: a pose is shifted across each direction that large surfaces face, up
/// to 96 voxels, as it is and turned about it by half a turn, or, about the first one, by quarters; shifted so that it
/// takes one of four samples to any surface that faces as the sample does; and turned about each of these directions
/// and the principal axes by any angle. Displacements that are drawn at random hardly ever hit the one place to which a
/// scene repeats itself.
class RivalSearch {
 public:
  static constexpr double kCoarse = 2.0;

  /// coarse: the target's surfaces in cubes of kCoarse voxels. voxel: the side of the target's voxels, > 0. Both are
  /// referred to.
  RivalSearch(const SurfaceMap& coarse, const SurfaceLayout& layout, double voxel)
      : coarse_(coarse), layout_(layout), voxel_(voxel) {}

  /// The highest peaks, not refined, the pose itself not among them. telling: some of the source's surface points that
  /// agree at the pose.
  [[nodiscard]] std::vector<RigidTransform> peaks(const RigidTransform& pose,
                                                  const std::vector<SurfacePoint>& telling) const;

  /// Whether the other pose takes the surfaces more than six voxels from where the pose does, root mean square.
  [[nodiscard]] bool is_another(const RigidTransform& pose, const RigidTransform& other) const;

 private:
  using Peak = std::pair<std::size_t, RigidTransform>;  // samples that agree, pose

  [[nodiscard]] std::vector<Peak> shifted(const RigidTransform& pose, const std::vector<SurfacePoint>& telling,
                                          const Eigen::Vector3d& direction, int quarter_turns) const;
  [[nodiscard]] std::vector<Peak> shifted_to_like(const RigidTransform& pose,
                                                  const std::vector<SurfacePoint>& telling) const;
  [[nodiscard]] std::vector<Peak> turned(const RigidTransform& pose, const std::vector<SurfacePoint>& telling,
                                         const Eigen::Vector3d& axis) const;
  /// Samples that agree, 0 where the first ones hardly do. place(i): where sample i is.
  template <typename Place>
  [[nodiscard]] std::size_t agreeing(std::size_t samples, const Place& place) const;

  const SurfaceMap& coarse_;
  const SurfaceLayout& layout_;
  double voxel_;
};

}  // namespace consimd::features::detail
