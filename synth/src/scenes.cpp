#include "scenes.hpp"

#include <numbers>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::synth {
namespace {

// A scanner's height over its half extent, and the angles by which its beams look down, in degrees.
constexpr double kScannerHeight = 1.0 / 50.0;
constexpr double kFlattestBeam = 3.0;
constexpr double kSteepestBeam = 28.0;
// Width and height of a window over the distance between windows.
constexpr double kWindowWidth = 0.4;
constexpr double kWindowHeight = 0.5;

Eigen::Vector3d half_extents(const HardProblemOptions& o) {
  const double e = o.half_extent;
  switch (o.scene) {
    case Scene::planar:
      return {e, e, 0.5 * o.thickness};
    case Scene::linear:
      return {e, 0.5 * o.thickness, 0.5 * o.thickness};
    case Scene::poles:
      return {e, e, e / 12.0};
    case Scene::lines:
      return {e, e, e / 6.0};
    case Scene::corridor:
      return {e, e / 20.0, e / 24.0};
    case Scene::room:
      return {e, e, e / 4.0};
    case Scene::street:
      return {e, e / 8.0, e / 12.0};
    case Scene::volume:
    case Scene::rings:
    case Scene::facade:
    case Scene::grid:
      break;
  }
  return Eigen::Vector3d::Constant(e);
}

}  // namespace

ScenePair::ScenePair(const HardProblemOptions& options, RandomStream& layout)
    : scene_(options.scene),
      half_extent_(options.half_extent),
      parts_(static_cast<std::uint32_t>(options.parts)),
      box_(half_extents(options)) {
  const Eigen::Vector3d& b = box_;
  if (has_faces()) areas_ = {b[1] * b[2], b[2] * b[0], b[0] * b[1]};
  if (scene_ == Scene::corridor || scene_ == Scene::street) areas_[0] = 0.0;  // open ends
  if (scene_ == Scene::street) areas_[2] *= 0.5;                              // no ceiling
  if (scene_ != Scene::poles && scene_ != Scene::lines) return;
  for (std::vector<Segment>* segments : {&segments_, &others_}) {
    for (std::uint32_t k = 0; k < parts_; ++k) {
      Segment segment{layout.in_box(box_), layout.in_box(box_)};
      if (scene_ == Scene::poles) {
        segment.from[2] = -box_[2];
        segment.to = {segment.from[0], segment.from[1], box_[2]};
      }
      segments->push_back(segment);
    }
  }
}

bool ScenePair::has_faces() const {
  return scene_ == Scene::corridor || scene_ == Scene::room || scene_ == Scene::street;
}

double ScenePair::ring_radius(std::uint32_t ring) const {
  const double degrees = kFlattestBeam + (kSteepestBeam - kFlattestBeam) * ring / parts_;
  const auto [sine, cosine] = elementary::sine_cosine(degrees * std::numbers::pi / 180.0);
  return kScannerHeight * half_extent_ * (cosine / sine);
}

double ScenePair::place(std::uint32_t k, std::uint32_t count) const {
  return half_extent_ * ((2.0 * k + 1.0) / count - 1.0);
}

Eigen::Vector3d ScenePair::on_ring(std::uint32_t ring, RandomStream& random) const {
  const double radius = ring_radius(ring);
  const auto azimuth = elementary::sine_cosine(random.uniform(0.0, 2.0 * std::numbers::pi));
  return {radius * azimuth.cosine, radius * azimuth.sine, -kScannerHeight * half_extent_};
}

std::uint32_t ScenePair::random_face(RandomStream& random) const {
  const double total = areas_[0] + areas_[1] + areas_[2];
  const double at = random.uniform(0.0, total);
  const std::uint32_t axis = at < areas_[0] ? 0 : at < areas_[0] + areas_[1] ? 1 : 2;
  const std::uint32_t side = random.below(2);
  return 2 * axis + (scene_ == Scene::street && axis == 2 ? 0 : side);
}

Eigen::Vector3d ScenePair::on_face(std::uint32_t face, RandomStream& random) const {
  Eigen::Vector3d point = random.in_box(box_);
  const auto axis = static_cast<Eigen::Index>(face / 2);
  point[axis] = face % 2 == 0 ? -box_[axis] : box_[axis];
  return point;
}

std::uint32_t ScenePair::window_rows() const { return (parts_ + 1) / 2; }

Eigen::Vector3d ScenePair::window_corner(std::uint32_t corner) const {
  const double pitch = 2.0 * half_extent_ / parts_;
  return {(corner % 2 == 0 ? -0.5 : 0.5) * kWindowWidth * pitch, (corner / 2 == 0 ? -0.5 : 0.5) * kWindowHeight * pitch,
          0.0};
}

Eigen::Vector3d ScenePair::at_any_window(std::uint32_t corner, RandomStream& random) const {
  const double column = place(random.below(parts_), parts_);
  // Rows are as far apart as columns.
  const double row = place(random.below(window_rows()), window_rows()) * window_rows() / parts_;
  return window_corner(corner) + Eigen::Vector3d(column, row, 0.0);
}

ScenePair::Point ScenePair::point(RandomStream& random) const {
  switch (scene_) {
    case Scene::rings: {
      const std::uint32_t ring = random.below(parts_);
      return {on_ring(ring, random), ring};
    }
    case Scene::poles:
    case Scene::lines: {
      const std::uint32_t k = random.below(parts_);
      return {segments_[k].from + random.uniform() * (segments_[k].to - segments_[k].from), k};
    }
    case Scene::corridor:
    case Scene::room:
    case Scene::street: {
      const std::uint32_t face = random_face(random);
      return {on_face(face, random), face};
    }
    case Scene::facade: {
      const std::uint32_t corner = random.below(4);
      return {at_any_window(corner, random), corner};
    }
    case Scene::grid: {
      const std::uint32_t x = random.below(parts_), y = random.below(parts_), z = random.below(parts_);
      return {{place(x, parts_), place(y, parts_), place(z, parts_)}, 0};
    }
    case Scene::volume:
    case Scene::planar:
    case Scene::linear:
      break;
  }
  return {random.in_box(box_), 0};
}

Eigen::Vector3d ScenePair::alike(const Point& point, RandomStream& random) const {
  switch (scene_) {
    case Scene::volume: {
      Eigen::Vector3d direction = random.gaussian_vector();
      while (!(direction.norm() > 0.0)) direction = random.gaussian_vector();
      return point.position.norm() * direction.normalized();
    }
    case Scene::rings:
      return on_ring(point.part, random);
    case Scene::poles: {
      const Eigen::Vector3d& foot = others_[random.below(parts_)].from;
      return {foot[0], foot[1], point.position[2]};
    }
    case Scene::lines: {
      const Segment& line = others_[point.part];
      return line.from + random.uniform() * (line.to - line.from);
    }
    case Scene::corridor:
    case Scene::street:
      return {random.uniform(-box_[0], box_[0]), point.position[1], point.position[2]};
    case Scene::room:
      return on_face(point.part, random);
    case Scene::facade:
      return at_any_window(point.part, random);
    case Scene::planar:
    case Scene::linear:
    case Scene::grid:
      break;
  }
  return this->point(random).position;
}

double ScenePair::mean_square_range() const {
  // The mean square of one coordinate at `count` evenly spaced places.
  const auto mean_square_place = [&](std::uint32_t count) {
    return half_extent_ * half_extent_ / 3.0 * (1.0 - 1.0 / (static_cast<double>(count) * count));
  };
  const Eigen::Vector3d squares = box_.cwiseAbs2();
  switch (scene_) {
    case Scene::rings: {
      double sum = 0.0;
      for (std::uint32_t ring = 0; ring < parts_; ++ring) sum += ring_radius(ring) * ring_radius(ring);
      return sum / parts_ + kScannerHeight * kScannerHeight * half_extent_ * half_extent_;
    }
    case Scene::poles:
    case Scene::lines: {
      double sum = 0.0;
      for (const Segment& s : segments_) sum += s.from.squaredNorm() + s.from.dot(s.to) + s.to.squaredNorm();
      return sum / (3.0 * parts_);
    }
    case Scene::corridor:
    case Scene::room:
    case Scene::street: {
      double sum = 0.0;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        sum += areas_[static_cast<std::size_t>(axis)] * (squares.sum() + 2.0 * squares[axis]) / 3.0;
      }
      return sum / (areas_[0] + areas_[1] + areas_[2]);
    }
    case Scene::facade: {
      const double rows = static_cast<double>(window_rows()) / parts_;
      return mean_square_place(parts_) + rows * rows * mean_square_place(window_rows()) +
             window_corner(0).squaredNorm();
    }
    case Scene::grid:
      return 3.0 * mean_square_place(parts_);
    case Scene::volume:
    case Scene::planar:
    case Scene::linear:
      break;
  }
  return squares.sum() / 3.0;
}

}  // namespace consimd::synth
