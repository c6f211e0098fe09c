#include "verification/displaced_poses.hpp"

#include <Random123/philox.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace consimd::features::detail {
namespace {

constexpr std::uint32_t kStream = 101;  // 100 draws subsets, the solvers' are lower

/// Random numbers of one displacement.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint32_t family, std::uint32_t index)
      : key_{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}},
        counter_{{0, kStream, family, index}} {}

  /// Four numbers in (0, 1).
  std::array<double, 4> next() {
    const auto words = r123::Philox4x32()(counter_, key_);
    ++counter_[0];
    std::array<double, 4> u;
    for (std::size_t k = 0; k < 4; ++k) u[k] = (static_cast<double>(words[k]) + 0.5) * 0x1p-32;
    return u;
  }

  /// A point of the unit disc, not its centre.
  Eigen::Vector2d in_disc() {
    for (;;) {
      const std::array<double, 4> u = next();
      for (std::size_t k = 0; k < 4; k += 2) {
        Eigen::Vector2d p(2.0 * u[k] - 1.0, 2.0 * u[k + 1] - 1.0);
        if (p.squaredNorm() < 1.0 && p.squaredNorm() > 0x1p-40) return p;
      }
    }
  }

 private:
  r123::Philox4x32::key_type key_;
  r123::Philox4x32::ctr_type counter_;
};

}  // namespace

Displacements::Displacements(const SurfaceLayout& layout, double least, std::uint64_t seed)
    // Clouds that are hardly larger than that have to be displaced all the same.
    : layout_(layout), least_(std::min(std::max(least, layout.spread / 6.0), 0.5 * layout.spread)), seed_(seed) {}

std::vector<RigidTransform> Displacements::of(const RigidTransform& pose, std::size_t count) const {
  const std::vector<Eigen::Vector3d>& directions = layout_.faced;
  const double spread = layout_.spread;
  const std::size_t faced = directions.size();
  const std::size_t families = 2 * faced + faced * (faced - 1) / 2;
  const auto each = static_cast<std::uint32_t>(count / families);
  std::vector<RigidTransform> displaced;
  displaced.reserve(families * each);
  std::uint32_t family = 0;
  const auto displace = [&](const RigidTransform& turned, const Eigen::Vector3d& shift) {
    displaced.push_back(turned);
    displaced.back().translation() += shift;
  };
  for (const Eigen::Vector3d& direction : directions) {
    const Eigen::Vector3d first = direction.unitOrthogonal();
    const Eigen::Vector3d second = direction.cross(first);
    for (const bool turned : {false, true}) {
      for (std::uint32_t k = 0; k < each; ++k) {
        Draws draws(seed_, family, k);
        for (;;) {
          const Eigen::Vector2d shift = spread * draws.in_disc();
          const Eigen::Vector2d half = draws.in_disc();
          double cosine = 1.0;
          double sine = 0.0;
          if (turned) {
            cosine = (half.x() * half.x() - half.y() * half.y()) / half.squaredNorm();
            sine = 2.0 * half.x() * half.y() / half.squaredNorm();
          } else if (half.x() < -0.5) {
            cosine = -1.0;
          }
          const double chord = spread * std::sqrt(std::max(2.0 - 2.0 * cosine, 0.0));
          if (shift.squaredNorm() + chord * chord < least_ * least_) continue;
          displace(turned_about(layout_.centre, direction, cosine, sine, pose), shift.x() * first + shift.y() * second);
          break;
        }
      }
      ++family;
    }
  }
  for (std::size_t i = 0; i < faced; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d line = directions[i].cross(directions[j]).normalized();
      for (std::uint32_t k = 0; k < each; ++k) {
        const std::array<double, 4> u = Draws(seed_, family, k).next();
        const double length = least_ + u[0] * (spread - least_);
        displace(pose, (u[1] < 0.5 ? -length : length) * line);
      }
      ++family;
    }
  }
  return displaced;
}

}  // namespace consimd::features::detail
