// Scans with their surfaces, as poses are held against them.
#pragma once

#include <cstdint>

#include <consimd/features/normals.hpp>
#include <consimd/features/pose_verification.hpp>
#include <consimd/features/voxel_grid.hpp>

#include "scene.hpp"

namespace consimd::test {

constexpr double kVoxel = 0.3;

struct Seen {
  Cloud scan;
  features::CellGrid surfaces;

  explicit Seen(const Points& points, double voxel = kVoxel)
      : scan(cloud_of(points)), surfaces(features::voxel_grid(scan, voxel), 3.0 * voxel) {
    features::estimate_normals(surfaces, {.radius = 2.0 * voxel});
  }
};

inline features::PoseEvidence evidence(const Seen& source, const Seen& target, const RigidTransform& pose,
                                       std::uint64_t seed = 1) {
  return features::PoseVerifier({source.scan, source.surfaces}, {target.scan, target.surfaces}, kVoxel, seed)
      .evidence(pose);
}

}  // namespace consimd::test
