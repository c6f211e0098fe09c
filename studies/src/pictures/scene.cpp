#include "pictures/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>

#include <fmt/format.h>

#include <consimd/features/cloud_matching.hpp>
#include <consimd/features/voxel_grid.hpp>

namespace consimd::studies {
namespace {

ScenePoint rounded(const Eigen::Vector3d& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

Eigen::Vector3d vector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

Eigen::Vector3d vector(const ScenePoint& p) { return Eigen::Vector3f(p[0], p[1], p[2]).cast<double>(); }

/// At most `most` of the items, in an order of which each beginning is spread evenly over all of them: positions with
/// the bits of a counter reversed.
template <typename T>
std::vector<T> spread(std::span<const T> items, std::size_t most) {
  std::vector<T> chosen;
  chosen.reserve(std::min(items.size(), most));
  int bits = 0;
  while ((std::size_t{1} << bits) < items.size()) ++bits;
  for (std::size_t counter = 0; counter < std::size_t{1} << bits && chosen.size() < most; ++counter) {
    std::size_t position = 0;
    for (int bit = 0; bit < bits; ++bit) position |= ((counter >> bit) & 1U) << (bits - 1 - bit);
    if (position < items.size()) chosen.push_back(items[position]);
  }
  return chosen;
}

/// The smallest voxel, to a fifth, that leaves at most `most` of the cloud's points.
double voxel_for(const Cloud& cloud, std::size_t most) {
  constexpr double kStep = 1.2;
  const double least = 2.0 / cloud.scale() / 0x1p19;  // well above what voxel_grid takes
  double voxel = std::max(features::choose_voxel(cloud), least);
  while (features::occupied_voxels(cloud, voxel) > most) voxel *= kStep;
  while (voxel / kStep > least && features::occupied_voxels(cloud, voxel / kStep) <= most) voxel /= kStep;
  return voxel;
}

SceneCloud scene_cloud(const Cloud& cloud, std::size_t most) {
  SceneCloud scene{.origin = cloud.origin(), .points = {}, .size = cloud.size()};
  const auto copy = [&scene](const Cloud& points) {
    scene.points.resize(points.size());
    const CloudView view = points.view();
    const auto unit = static_cast<float>(1.0 / view.scale());  // a power of two: nothing is rounded
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) scene.points[i][axis] = unit * view.points(axis)[i];
    }
  };
  if (cloud.size() <= most) {
    copy(cloud);
  } else {
    scene.voxel = voxel_for(cloud, most);
    copy(features::voxel_grid(cloud, scene.voxel));
  }
  return scene;
}

/// Row `row` of one side of the correspondences about `origin`.
ScenePoint row_point(const Correspondences& rows, bool target, std::size_t row, const std::array<double, 3>& origin) {
  const CorrespondenceView view = rows.view();
  const std::array<double, 3>& centroid = target ? rows.target_centroid() : rows.source_centroid();
  Eigen::Vector3d p;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float at = target ? view.target(axis)[row] : view.source(axis)[row];
    p[static_cast<Eigen::Index>(axis)] = static_cast<double>(at) / view.scale() + (centroid[axis] - origin[axis]);
  }
  return rounded(p);
}

SceneCloud scene_cloud(const Correspondences& rows, bool target, std::span<const std::uint32_t> near,
                       std::size_t most) {
  SceneCloud scene{
      .origin = target ? rows.target_centroid() : rows.source_centroid(), .points = {}, .size = near.size()};
  for (const std::uint32_t row : spread(near, most)) {
    scene.points.push_back(row_point(rows, target, row, scene.origin));
  }
  return scene;
}

SceneLines scene_lines(const Correspondences& rows, std::span<const std::uint32_t> chosen, const Scene& scene,
                       std::size_t most) {
  SceneLines lines{.drawn = {}, .size = chosen.size()};
  for (const std::uint32_t row : spread(chosen, most)) {
    lines.drawn.push_back(
        {row_point(rows, false, row, scene.source.origin), row_point(rows, true, row, scene.target.origin)});
  }
  return lines;
}

// Enough for a frame, and quick for any cloud.
constexpr std::size_t kSample = 20'000;

std::vector<Eigen::Vector3d> sample(const SceneCloud& cloud) {
  std::vector<Eigen::Vector3d> points;
  for (const ScenePoint& p : spread(std::span(cloud.points), kSample)) points.push_back(vector(p));
  return points;
}

/// The value that a share of the numbers is below.
double quantile(std::vector<double> numbers, double share) {
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(numbers.size() - 1));
  std::nth_element(numbers.begin(), numbers.begin() + rank, numbers.end());
  return numbers[static_cast<std::size_t>(rank)];
}

Eigen::Vector3d median(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d middle;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::vector<double> numbers;
    numbers.reserve(points.size());
    for (const Eigen::Vector3d& p : points) numbers.push_back(p[axis]);
    middle[axis] = quantile(std::move(numbers), 0.5);
  }
  return middle;
}

/// A few points far from all others shall not make the rest a speck.
constexpr double kFramedShare = 0.96;

double radius_about(const Eigen::Vector3d& middle, const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> distances;
  distances.reserve(points.size());
  for (const Eigen::Vector3d& p : points) distances.push_back((p - middle).norm());
  return quantile(std::move(distances), kFramedShare);
}

struct Samples {
  std::vector<Eigen::Vector3d> source;
  std::vector<Eigen::Vector3d> target;
};

Placement placement(std::string name, const Eigen::Affine3d& T_target_source, const Samples& samples) {
  Placement made{.name = std::move(name), .T_target_source = T_target_source};
  std::vector<Eigen::Vector3d> all = samples.target;
  for (const Eigen::Vector3d& p : samples.source) all.emplace_back(T_target_source * p);
  made.focus = median(all);
  made.radius = radius_about(made.focus, all);
  if (!(made.radius > 0.0)) made.radius = 1.0;
  return made;
}

/// The similarity x_target = R (scale * x_source) + t between points about the origins of their clouds.
Eigen::Affine3d about_origins(const RigidTransform& pose, double scale, const Scene& scene) {
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  T.linear() = scale * pose.linear();
  T.translation() = pose * Eigen::Vector3d(scale * vector(scene.source.origin)) - vector(scene.target.origin);
  return T;
}

/// The source as given, or beside the target where the two are so far apart that both would be specks.
Placement placement_before(Scene& scene, const Samples& samples) {
  const Eigen::Vector3d source = median(samples.source), target = median(samples.target);
  const double reach = radius_about(source, samples.source) + radius_about(target, samples.target);
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  T.translation() = vector(scene.source.origin) - vector(scene.target.origin);
  const Eigen::Vector3d apart = T * source - target;
  constexpr double kFarApart = 3.0;
  if (apart.norm() > kFarApart * reach && reach > 0.0) {
    const Eigen::Vector3d nearer = apart * (1.0 - reach / apart.norm());
    T.translation() -= nearer;
    scene.gap = nearer.norm();
  }
  return placement("before", T, samples);
}

/// Depth cameras look along z with y down, and see nothing outside of a cone before them; everybody else has z up.
Eigen::Vector3d up_axis(const SceneCloud& target, const std::vector<Eigen::Vector3d>& points) {
  constexpr double kWidest = 1.5;  // x or y over z at the edge of a wide camera's picture
  std::size_t before = 0;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d at = p + vector(target.origin);
    if (at.z() > 0.0 && std::max(std::abs(at.x()), std::abs(at.y())) < kWidest * at.z()) ++before;
  }
  return before > points.size() - points.size() / 50 ? Eigen::Vector3d(-Eigen::Vector3d::UnitY())
                                                     : Eigen::Vector3d::UnitZ();
}

void check(const RegistrationPicture& picture) {
  if (picture.correspondences == nullptr || picture.registration == nullptr) {
    throw std::invalid_argument("a picture needs correspondences and their registration");
  }
  if ((picture.source == nullptr) != (picture.target == nullptr)) {
    throw std::invalid_argument("a picture needs both clouds, or none");
  }
  if (picture.source != nullptr && (picture.source->empty() || picture.target->empty())) {
    throw std::invalid_argument(
        fmt::format("the {} cloud of the picture is empty", picture.source->empty() ? "source" : "target"));
  }
  for (const std::uint32_t row : picture.registration->inliers) {
    if (row >= picture.correspondences->size()) {
      throw std::invalid_argument(
          fmt::format("inlier {} is none of the picture's {} correspondences", row, picture.correspondences->size()));
    }
  }
}

}  // namespace

Scene make_scene(const RegistrationPicture& picture, std::size_t most_points, std::size_t most_lines) {
  check(picture);
  const Correspondences& rows = *picture.correspondences;
  const Registration& run = *picture.registration;
  const std::vector<std::uint32_t> near = rows.near_rows();
  Scene scene;
  if (picture.source != nullptr) {
    scene.source = scene_cloud(*picture.source, most_points);
    scene.target = scene_cloud(*picture.target, most_points);
  } else {
    scene.source = scene_cloud(rows, false, near, most_points);
    scene.target = scene_cloud(rows, true, near, most_points);
  }
  if (scene.source.points.empty()) throw std::invalid_argument("a picture needs at least one correspondence");

  std::vector<std::uint32_t> inliers, outliers;
  for (const std::uint32_t row : near) {
    const bool inlier = std::binary_search(run.inliers.begin(), run.inliers.end(), row);
    (inlier ? inliers : outliers).push_back(row);
  }
  scene.inliers = scene_lines(rows, inliers, scene, most_lines);
  scene.outliers = scene_lines(rows, outliers, scene, most_lines);
  scene.far_rows = rows.far_rows().size();

  const Samples samples{sample(scene.source), sample(scene.target)};
  scene.up = up_axis(scene.target, samples.target);
  scene.placements.push_back(placement_before(scene, samples));
  if (run.has_pose()) {
    scene.placements.push_back(placement("after", about_origins(run.T_target_source, run.scale, scene), samples));
    if (run.runner_up) {
      scene.placements.push_back(
          placement("runner-up", about_origins(run.runner_up->T_target_source, run.runner_up->scale, scene), samples));
    }
  }
  return scene;
}

}  // namespace consimd::studies
