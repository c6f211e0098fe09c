// Whether two clouds bear out a pose that was found from their correspondences.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// One of the clouds of a verification.
struct VerifiedCloud {
  /// All points that the scanner measured: what they were seen through is free space.
  const Cloud& scan;
  /// What its surfaces are made of: the same points thinned out to about one a voxel, with normals (see normals.hpp).
  const CellGrid& surfaces;
  /// Where the scan was taken from, caller's frame; without one nothing is known of free space.
  std::optional<std::array<double, 3>> viewpoint = std::array<double, 3>{0.0, 0.0, 0.0};
};

/// Another pose at which two clouds agree.
struct RivalPose {
  RigidTransform T_target_source = RigidTransform::Identity();  ///< caller's frames
  /// Of the pose's score, both fitted to the surfaces: the samples that agree, each by how rarely it does and how close
  /// it is, less those seen through. Above 1: the rival is better.
  double share_of_score = 0.0;
  /// The samples that agree at the rival over those that agree at the pose, both fitted to the surfaces.
  double share_of_agreement = 0.0;
  double agreement = 0.0;     ///< as in PoseEvidence
  double seen_through = 0.0;  ///< as in PoseEvidence
};

/// How two clouds agree if one may be of another scale.
struct ScaledFit {
  double scale = 1.0;  ///< of the source, where that is better than 1
  /// How closely the surfaces agree with the pose fitted at that scale, over how they do with it fitted at the scale 1.
  double gain = 1.0;
};

/// How well two clouds agree at a pose. A sample is a surface point of one of the clouds, brought into the other's
/// frame.
struct PoseEvidence {
  /// log10 of the chance that clouds which have nothing in common but what every displacement keeps agree as well:
  /// ground, walls and corridors agree wherever one is shifted along them. By the displaced poses' own agreement.
  double log10_chance = 0.0;
  double agreement = 0.0;            ///< share of samples that lie on a surface of the other cloud, of like orientation
  double seen_through = 0.0;         ///< share of samples where the other scan saw nothing but what is farther away
  std::size_t samples = 0;           ///< 0: a cloud has no surfaces, and nothing is known
  std::size_t displacements = 0;     ///< poses that the chance comes from
  double displaced_agreement = 0.0;  ///< as `agreement`, mean of the displaced poses
  double displaced_seen_through = 0.0;  ///< as `seen_through`, mean of the displaced poses
  /// As `agreement` and `seen_through`, with the pose fitted to the surfaces near it; 0 where its chance is not
  /// below 1 in 20.
  double fitted_agreement = 0.0;
  double fitted_seen_through = 0.0;
  /// The best other pose at which the clouds agree, where a scene repeats itself or about an axis of symmetry; before
  /// better ones that are seen through, the best that is as good as the pose (see has_equal_rival). None where there is
  /// no such, or the pose's own chance is above 1 in 20.
  std::optional<RivalPose> rival = std::nullopt;
  ScaledFit scaled = {};  ///< of a pose whose chance is below 1 in 20
};

/// Holds poses against two clouds. The chance of a pose is found by displacing it: turned about the normal of a large
/// plane and shifted in it, or along the line that two such planes have in common, by more than surfaces are matched
/// to. What the surfaces agree in at most displacements counts little: each sample weighs as much as its agreement is
/// rare. The tail of the displaced poses' agreement is extrapolated as an exponential one. Of a pose that agrees better
/// than most of these, the best other one is looked for, and the scale at which the clouds agree best. Deterministic in
/// the seed, the same for any number of threads and instruction set; parallel with oneTBB.
class PoseVerifier {
 public:
  /// voxel: side of the voxels of both clouds' surfaces, caller's unit, > 0. Both clouds are read during construction
  /// only. Throws std::invalid_argument on a bad voxel, on one that a cloud is more than 2^20 times as long as, or on a
  /// viewpoint that is not finite.
  PoseVerifier(const VerifiedCloud& source, const VerifiedCloud& target, double voxel, std::uint64_t seed = 1);
  PoseVerifier(const PoseVerifier&) = delete;
  PoseVerifier& operator=(const PoseVerifier&) = delete;
  ~PoseVerifier();
  PoseVerifier(PoseVerifier&&) noexcept;
  PoseVerifier& operator=(PoseVerifier&&) noexcept;

  /// T_target_source: caller's frames. Throws std::invalid_argument on one that is not finite.
  [[nodiscard]] PoseEvidence evidence(const RigidTransform& T_target_source) const;

  /// The pose moved onto the surfaces near it, point to plane, from a few hundred samples. Caller's frames. It may
  /// slide along what no surface holds. Throws as evidence does.
  [[nodiscard]] RigidTransform fitted(const RigidTransform& T_target_source) const;

  /// Whether two poses (T_target_source, caller's frames) bring the source's surfaces, which lie as the target's do,
  /// within six voxels of one another, root mean square. Throws as evidence does.
  [[nodiscard]] bool are_alike(const RigidTransform& pose, const RigidTransform& other) const;

 private:
  struct Clouds;
  std::unique_ptr<Clouds> clouds_;
};

}  // namespace features
}  // namespace consimd
