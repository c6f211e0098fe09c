// What a picture of a registration draws, thinned out, in frames that single precision suffices for.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include <consimd/studies/registration_picture.hpp>

namespace consimd::studies {

using ScenePoint = std::array<float, 3>;

/// Points about `origin`, which is given in the caller's frame.
struct SceneCloud {
  std::array<double, 3> origin{};
  std::vector<ScenePoint> points;
  std::size_t size = 0;  ///< points that there are
  double voxel = 0.0;    ///< that `points` are the means of, caller's unit; 0: the points themselves
};

/// A correspondence, each point about the origin of its cloud.
struct SceneLine {
  ScenePoint source{};
  ScenePoint target{};
};

struct SceneLines {
  std::vector<SceneLine> drawn;
  std::size_t size = 0;  ///< lines that there are
};

/// One way to see the source with the target.
struct Placement {
  std::string name;
  /// From the source's points to the target's, each about its origin: a similarity.
  Eigen::Affine3d T_target_source = Eigen::Affine3d::Identity();
  /// The middle of what is seen, and a distance from it within which nearly all of it is; target's points.
  Eigen::Vector3d focus = Eigen::Vector3d::Zero();
  double radius = 1.0;
};

struct Scene {
  SceneCloud source;
  SceneCloud target;
  SceneLines inliers;
  SceneLines outliers;
  std::vector<Placement> placements;  ///< before, after if there is a pose, runner-up if there is one
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  std::size_t far_rows = 0;  ///< correspondences far from all others, which are not drawn
  double gap = 0.0;          ///< distance that the source was brought nearer by to be seen before the pose; 0: as given
};

/// Where the pictures are looked at from at first: angles about the axis that is up and above the plane that it is
/// normal to, and of the field of view; rad.
inline constexpr double kYaw = -1.05;
inline constexpr double kPitch = 0.65;
inline constexpr double kField = 0.7;

/// Throws as `registration_page`.
[[nodiscard]] Scene make_scene(const RegistrationPicture& picture, std::size_t most_points, std::size_t most_lines);

}  // namespace consimd::studies
