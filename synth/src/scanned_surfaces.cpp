#include "scanned_surfaces.hpp"

#include <cmath>
#include <numbers>

#include <consimd/kernels/elementary_functions.hpp>

namespace consimd::synth {
namespace {

using Eigen::Vector3d;

/// Distance of x from the middle of its period, 0 to 1.
double folded(double x, double period) { return std::abs(2.0 * (x / period - std::floor(x / period)) - 1.0); }

/// Puts up a scene piece by piece. Lengths in metres; sizes scatter so that no two pairs share a scene. Random numbers
/// are drawn one in a statement: in which order the arguments of a call are evaluated is the compiler's choice.
class Builder {
 public:
  explicit Builder(RandomStream& random) : random_(random) {}

  std::vector<Surface> take() { return std::move(surfaces_); }

  void ground(double length, double width, double height = 0.0) {
    rectangle(SurfaceKind::ground, {-0.5 * length, -0.5 * width, height}, {length, 0.0, 0.0}, {0.0, width, 0.0}, 9.0,
              7.0);
  }

  void ceiling(double length, double width, double height, double panel) {
    rectangle(SurfaceKind::ceiling, {-0.5 * length, -0.5 * width, height}, {length, 0.0, 0.0}, {0.0, width, 0.0}, panel,
              panel);
  }

  /// Upright, from one foot point to the other; windows repeat along it and from floor to floor.
  void wall(const Vector3d& from, const Vector3d& to, double height, double window, double floor,
            SurfaceKind kind = SurfaceKind::wall) {
    rectangle(kind, from, to - from, {0.0, 0.0, height}, window, floor);
  }

  /// Four upright sides and a top.
  void box(const Vector3d& centre, double length, double width, double height, SurfaceKind kind, double turn) {
    const auto [sine, cosine] = elementary::sine_cosine(turn);
    const Vector3d x(0.5 * length * cosine, 0.5 * length * sine, 0.0);
    const Vector3d y(-0.5 * width * sine, 0.5 * width * cosine, 0.0);
    const Vector3d up(0.0, 0.0, height);
    rectangle(kind, centre - x - y, 2.0 * x, up, 0.0, 0.0);
    rectangle(kind, centre - x + y, 2.0 * x, up, 0.0, 0.0);
    rectangle(kind, centre - x - y, 2.0 * y, up, 0.0, 0.0);
    rectangle(kind, centre + x - y, 2.0 * y, up, 0.0, 0.0);
    rectangle(kind, centre - x - y + up, 2.0 * x, 2.0 * y, 0.0, 0.0);
  }

  void tree(const Vector3d& foot) {
    const double trunk = random_.uniform(2.0, 5.0), crown = random_.uniform(1.0, 2.5);
    surfaces_.push_back(Surface::cylinder(SurfaceKind::trunk, foot, random_.uniform(0.15, 0.4), trunk));
    surfaces_.push_back(Surface::ball(SurfaceKind::foliage, foot + Vector3d(0.0, 0.0, trunk + 0.7 * crown), crown));
  }

  void pole(const Vector3d& foot, double radius, double height) {
    surfaces_.push_back(Surface::cylinder(SurfaceKind::pole, foot, radius, height));
  }

  void cars(int count, double from_axis) {
    for (int k = 0; k < count; ++k) {
      box(beside_axis(45.0, from_axis, from_axis + 1.0), 4.2, 1.8, 1.5, SurfaceKind::furniture, 0.0);
    }
  }

  void trees(int count, double nearest, double farthest) {
    for (int k = 0; k < count; ++k) tree(beside_axis(45.0, nearest, farthest));
  }

  void poles(int count, double from_axis) {
    for (int k = 0; k < count; ++k) {
      const Vector3d foot = beside_axis(50.0, from_axis, from_axis + 0.5);
      pole(foot, 0.12, random_.uniform(5.0, 8.0));
    }
  }

  /// Fronts along both sides of a street, with gaps.
  void houses(int count, double from_axis) {
    for (int k = 0; k < count; ++k) {
      const Vector3d near = beside_axis(45.0, from_axis, from_axis + 4.0);
      const double length = random_.uniform(8.0, 18.0), depth = random_.uniform(6.0, 10.0);
      const double height = random_.uniform(5.0, 11.0), outwards = near.y() > 0.0 ? depth : -depth;
      wall(near, near + Vector3d(length, 0.0, 0.0), height, 2.8, 3.0);
      wall(near, near + Vector3d(0.0, outwards, 0.0), height, 2.8, 3.0);
      wall(near + Vector3d(length, 0.0, 0.0), near + Vector3d(length, outwards, 0.0), height, 2.8, 3.0);
    }
  }

  Vector3d beside_axis(double half_length, double nearest, double farthest) {
    const double x = random_.uniform(-half_length, half_length), y = random_.uniform(nearest, farthest);
    return {x, random_.uniform() < 0.5 ? -y : y, 0.0};
  }

  double size(double usual) { return usual * random_.uniform(0.85, 1.15); }
  double angle() { return random_.uniform(0.0, std::numbers::pi); }

 private:
  void rectangle(SurfaceKind kind, const Vector3d& origin, const Vector3d& across, const Vector3d& up,
                 double period_across, double period_up) {
    surfaces_.push_back(Surface::rectangle(kind, origin, across, up, period_across, period_up));
  }

  RandomStream& random_;
  std::vector<Surface> surfaces_;
};

void build_arch(Builder& b) {
  const double length = b.size(55.0), width = b.size(45.0);
  b.ground(length, width);
  const double pier = b.size(3.5), opening = b.size(5.0), height = b.size(9.0);
  for (const double side : {-1.0, 1.0}) {
    b.box({0.0, side * 0.5 * (opening + pier), 0.0}, pier, pier, height, SurfaceKind::wall, 0.0);
    b.wall({-14.0, side * 20.0, 0.0}, {14.0, side * 20.0, 0.0}, b.size(11.0), 3.2, 3.6);
    for (int k = -2; k <= 2; ++k) b.pole({5.0 * k + 1.5, side * 9.0, 0.0}, 0.35, 5.0);
  }
  b.box({0.0, 0.0, height}, pier, 2.0 * pier + opening, 0.3 * height, SurfaceKind::wall, 0.0);
}

void build_courtyard(Builder& b) {
  const double x = 0.5 * b.size(46.0), y = 0.5 * b.size(36.0), height = b.size(14.0);
  b.ground(2.0 * x, 2.0 * y);
  for (const double side : {-1.0, 1.0}) {
    b.wall({-x, side * y, 0.0}, {x, side * y, 0.0}, height, 3.8, 3.5);
    b.wall({side * x, -y, 0.0}, {side * x, y, 0.0}, height, 3.8, 3.5);
  }
  b.box({4.0, 7.0, 0.0}, 3.0, 3.0, 1.2, SurfaceKind::furniture, b.angle());
  for (int k = 0; k < 6; ++k) b.tree({-15.0 + 6.0 * k, -9.0, 0.0});
}

void build_facade(Builder& b) {
  const double half = 0.5 * b.size(34.0), height = b.size(16.0), distance = b.size(11.0);
  b.ground(2.2 * half, 2.4 * distance);
  b.wall({-half, distance, 0.0}, {half, distance, 0.0}, height, 2.9, 3.4);
  b.wall({half, distance, 0.0}, {half, -distance, 0.0}, b.size(9.0), 2.9, 3.4);
  b.cars(5, 5.0);
  for (int k = 0; k < 3; ++k) b.tree({-10.0 + 9.0 * k, -7.0, 0.0});
}

void build_office(Builder& b) {
  const double x = 0.5 * b.size(13.0), y = 0.5 * b.size(8.0), height = b.size(3.0);
  b.ground(2.0 * x, 2.0 * y);
  b.ceiling(2.0 * x, 2.0 * y, height, 0.6);
  for (const double side : {-1.0, 1.0}) {
    b.wall({-x, side * y, 0.0}, {x, side * y, 0.0}, height, 1.8, 0.0);
    b.wall({side * x, -y, 0.0}, {side * x, y, 0.0}, height, 0.0, 0.0);
    for (int k = -2; k <= 2; ++k) {
      b.box({2.3 * k, side * 0.55 * y, 0.0}, 1.6, 0.8, 0.75, SurfaceKind::furniture, 0.0);
      b.box({2.3 * k, side * 0.25 * y, 0.0}, 0.5, 0.5, 0.9, SurfaceKind::furniture, b.angle());
    }
  }
}

void build_trees(Builder& b) {
  const double length = b.size(50.0), width = b.size(50.0);
  b.ground(length, width);
  b.trees(28, 1.5, 22.0);
  b.wall({-20.0, 23.0, 0.0}, {12.0, 23.0, 0.0}, b.size(4.0), 0.0, 0.0);
}

void build_highway(Builder& b) {
  b.ground(110.0, b.size(22.0));
  for (const double y : {-9.5, 0.8, 9.5}) b.wall({-55.0, y, 0.0}, {55.0, y, 0.0}, 0.8, 4.0, 0.0, SurfaceKind::rail);
  const double from = b.size(14.0), to = b.size(14.0);
  b.wall({-55.0, from, 0.0}, {55.0, to, 0.0}, 3.0, 4.0, 0.0);
  b.poles(5, 10.0);
  b.cars(4, 4.0);
  b.trees(8, 15.0, 25.0);
}

void build_country(Builder& b) {
  b.ground(110.0, b.size(45.0));
  b.trees(24, 7.0, 22.0);
  b.houses(2, 10.0);
  b.poles(6, 5.0);
  b.cars(2, 3.0);
}

void build_urban(Builder& b) {
  b.ground(110.0, b.size(22.0));
  b.houses(10, 10.0);
  b.poles(8, 7.0);
  b.cars(10, 5.0);
  b.trees(6, 7.0, 9.0);
}

void build_mixed(Builder& b) {
  b.ground(110.0, b.size(30.0));
  b.houses(5, 10.0);
  b.trees(14, 7.0, 18.0);
  b.poles(6, 6.0);
  b.cars(6, 4.5);
}

}  // namespace

Surface Surface::rectangle(SurfaceKind kind, const Vector3d& origin, const Vector3d& across, const Vector3d& up,
                           double period_across, double period_up) {
  Surface s;
  s.shape_ = Shape::rectangle;
  s.kind_ = kind;
  s.origin_ = origin;
  s.across_ = across;
  s.up_ = up;
  s.period_across_ = period_across > 0.0 ? period_across : across.norm();
  s.period_up_ = period_up > 0.0 ? period_up : up.norm();
  return s;
}

Surface Surface::cylinder(SurfaceKind kind, const Vector3d& foot, double radius, double height) {
  Surface s = rectangle(kind, foot, {radius, 0.0, 0.0}, {0.0, 0.0, height}, 0.0, 2.0 * height);
  s.shape_ = Shape::cylinder;
  return s;
}

Surface Surface::ball(SurfaceKind kind, const Vector3d& centre, double radius) {
  Surface s = rectangle(kind, centre, {radius, 0.0, 0.0}, {0.0, 0.0, radius}, 0.0, 0.0);
  s.shape_ = Shape::ball;
  return s;
}

double Surface::area() const {
  switch (shape_) {
    case Shape::cylinder:
      return 2.0 * std::numbers::pi * across_.norm() * up_.norm();
    case Shape::ball:
      return 4.0 * std::numbers::pi * across_.squaredNorm();
    case Shape::rectangle:
      break;
  }
  return across_.norm() * up_.norm();
}

SurfacePoint Surface::sample(RandomStream& random) const {
  if (shape_ == Shape::ball) {
    const Vector3d normal = random.gaussian_vector().normalized();
    const Vector3d tangent = normal.unitOrthogonal();
    // Foliage is not a surface: points lie at any depth of its outer half.
    return {origin_ + across_.norm() * random.uniform(0.5, 1.0) * normal, tangent, normal.cross(tangent), normal};
  }
  const double a = random.uniform(), b = random.uniform();
  if (shape_ == Shape::cylinder) {
    const auto turn = elementary::sine_cosine(2.0 * std::numbers::pi * a);
    const Vector3d normal(turn.cosine, turn.sine, 0.0);
    const Vector3d up = up_.normalized();
    return {origin_ + across_.norm() * normal + b * up_, up.cross(normal), up, normal};
  }
  const Vector3d tangent = across_.normalized(), other = up_.normalized();
  return {origin_ + a * across_ + b * up_, tangent, other, tangent.cross(other)};
}

Look Surface::look(const Vector3d& position) const {
  if (shape_ == Shape::ball) return {kind_, 0.0, 0.0};
  const Vector3d from_origin = position - origin_;
  const double up = folded(from_origin.dot(up_.normalized()), period_up_);
  if (shape_ == Shape::cylinder) return {kind_, 0.0, up};  // the same all round
  return {kind_, folded(from_origin.dot(across_.normalized()), period_across_), up};
}

std::vector<Surface> scanned_scene(ScannedScene scene, RandomStream& random) {
  Builder builder(random);
  switch (scene) {
    case ScannedScene::arch:
      build_arch(builder);
      break;
    case ScannedScene::courtyard:
      build_courtyard(builder);
      break;
    case ScannedScene::facade:
      build_facade(builder);
      break;
    case ScannedScene::office:
      build_office(builder);
      break;
    case ScannedScene::trees:
      build_trees(builder);
      break;
    case ScannedScene::highway:
      build_highway(builder);
      break;
    case ScannedScene::country:
      build_country(builder);
      break;
    case ScannedScene::urban:
      build_urban(builder);
      break;
    case ScannedScene::mixed:
      build_mixed(builder);
      break;
  }
  return builder.take();
}

}  // namespace consimd::synth
