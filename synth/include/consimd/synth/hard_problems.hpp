// Problems that are harder than the noise study's: structured outliers, degenerate scenes, other noise, other frames.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <consimd/kernels/export.hpp>
#include <consimd/synth/problem.hpp>

namespace consimd {
namespace CONSIMD_EXPORT synth {

/// Where source points lie. All but the volume are turned at random. E: half_extent.
enum class Scene : std::uint8_t {
  volume,    ///< the cube [-E, E]^3
  planar,    ///< a square slab through the cube's centre, `thickness` thick
  linear,    ///< a square rod through the cube's centre, `thickness` thick
  rings,     ///< `parts` circles on the ground around a scanner at the origin, E / 50 above it, whose beams look down
             ///< by 3 to 28 degrees
  poles,     ///< `parts` verticals at random places of a square of 2 E, E / 6 high
  lines,     ///< `parts` segments between random points of a box of 2 E x 2 E x E / 3
  corridor,  ///< its walls, floor and ceiling: 2 E long, E / 10 wide, E / 12 high
  room,      ///< its six faces: 2 E x 2 E x E / 2
  street,    ///< the ground between two rows of houses: 2 E long, E / 4 wide, E / 6 high
  facade,    ///< corners of equal windows in `parts` columns, 2 E / parts apart, and half as many rows
  grid,      ///< nodes of a cubic lattice, `parts` an edge, 2 E / parts apart
};

/// What the correspondences are that no motion explains.
enum class OutlierModel : std::uint8_t {
  uniform,       ///< a scene point and a target uniform in the cube
  permuted,      ///< a scene point and the target of another outlier; each target is used once, so both clouds
                 ///< have the true shape. Needs two outliers
  clustered,     ///< `clusters` pairs of Gaussian clusters, one around a scene point, the other uniform in the cube;
                 ///< random association within a pair
  one_to_many,   ///< `matches_per_point` outliers share a scene point; targets uniform in the cube
  many_to_many,  ///< wrong pairs among the features that true pairs come from, as mutual top-k matching gives them: a
                 ///< point of either cloud is in at most `matches_per_point` correspondences, a true one included
  /// A scene point and a point of another scene of the kind that looks the same to a matcher, with the inliers' noise.
  /// The other scene has its own poles or lines and lies where decoy_T_target_source takes the first. Alike are points
  /// of a volume at the same distance from the origin; all of a plane, a rod or a grid; those on the same ring, face of
  /// the room, or line (the k-th and the k-th); of the same height on any pole; at the same place of the corridor's
  /// or the street's cross-section; and the same corners of any windows. So nothing but chance puts two pairs on one
  /// motion, yet far more of them lie on one than uniform outliers would.
  alike,
};

/// How an inlier's target deviates from the moved source. The standard deviation per axis is sigma over all inliers.
enum class NoiseModel : std::uint8_t {
  gaussian,
  range_dependent,  ///< Gaussian with a deviation in proportion to the distance from the source frame's origin
  student_t,        ///< heavy tails: an isotropic Student t vector with `degrees_of_freedom`
  anisotropic,      ///< Gaussian, its deviation along the ray from the source frame's origin `anisotropy` times that
                    ///< across it, as stereo cameras and time-of-flight sensors have it
};

/// The defaults are the noise study's problem; each option past `trial` makes it harder in one way, and all combine.
/// Lengths are in metres, whatever the unit of the result. The random numbers are keyed by seed, trial,
/// correspondences, outlier_ratio and sigma alone, so that problems that differ in another option share all that it
/// leaves untouched.
///
/// outlier_ratio = 1 gives a problem without any true pose; its T_target_source only says where the target cloud lies.
struct HardProblemOptions {
  std::size_t correspondences = 3000;  ///< N, [1, 2^32)
  double outlier_ratio = 0.9;          ///< [0, 1]; floor(N * (1 - ratio) + 1/2) inliers remain
  double sigma = 1.0;                  ///< >= 0
  double half_extent = 100.0;          ///< > 0, also bounds each axis of a motion's translation
  std::uint64_t seed = 1;
  std::uint64_t trial = 0;

  Scene scene = Scene::volume;
  double thickness = 0.1;  ///< >= 0; planar and linear scenes
  std::size_t parts = 20;  ///< [1, 2^32); rings, poles, lines, columns of windows, nodes an edge of the grid

  OutlierModel outliers = OutlierModel::uniform;
  std::size_t clusters = 10;          ///< >= 1; clustered
  double cluster_sigma = 2.0;         ///< >= 0, deviation per axis; clustered
  std::size_t matches_per_point = 3;  ///< >= 2; one_to_many and many_to_many
  double decoy_share = 0.0;  ///< >= 0; this share of the inliers' number, rounded, is taken from the outliers to
                             ///< follow a second rigid motion with the inliers' noise
  /// The scene is its own image under a half turn about its first axis: points come in pairs, and decoys are matches
  /// with the counterpart of a point's image, so their motion is the true one after the half turn.
  bool symmetric = false;

  NoiseModel noise = NoiseModel::gaussian;
  unsigned degrees_of_freedom = 3;  ///< >= 3, where the deviation is finite; student_t
  double anisotropy = 5.0;          ///< > 0; anisotropic

  std::size_t duplicates = 0;  ///< copies of random rows, in addition to N

  // Applied to the finished rows, in this order.
  bool mirrored = false;  ///< the source becomes its mirror image (x -> -x): only a reflection explains the
                          ///< data, so no row is labelled an inlier
  double quantum = 0.0;   ///< > 0 rounds every coordinate to a multiple
  std::array<double, 3> source_offset{};  ///< added to source points, as map coordinates are
  std::array<double, 3> target_offset{};  ///< added to target points
  double units_per_metre = 1.0;           ///< > 0; 1000 gives millimetres. Scales the points, the pose and sigma
  double scale = 1.0;                     ///< > 0; source points are divided by it, so that it is to be found
};

/// The problem, rows in random order. Throws std::invalid_argument on an option outside its range, and when the decoy
/// asks for more rows than there are outliers.
[[nodiscard]] Problem hard_problem(const HardProblemOptions& options);

}  // namespace synth
}  // namespace consimd
