#include "verification/displaced_poses.hpp"

#include <Random123/philox.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <consimd/features/point_subset.hpp>

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

/// Directions that at least a twentieth of the normals lie within 15 degrees of, either way, the largest first; the
/// next is sought among normals that are more than 30 degrees from those before.
std::vector<Eigen::Vector3d> faced_directions(const std::vector<SurfacePoint>& surfaces, std::uint64_t seed) {
  constexpr std::size_t kMost = 3;
  constexpr std::size_t kCandidates = 64;
  constexpr std::size_t kNormals = 2000;
  constexpr double kShare = 0.05;
  const double within = std::sqrt(0.5 + 0.25 * std::sqrt(3.0));  // cos 15 degrees
  const double beside = 0.5 * std::sqrt(3.0);                    // cos 30 degrees
  std::vector<Eigen::Vector3d> normals;
  for (const std::uint32_t row : random_subset(surfaces.size(), kNormals, seed)) {
    normals.emplace_back(surfaces[row].normal[0], surfaces[row].normal[1], surfaces[row].normal[2]);
  }
  const double needed = kShare * static_cast<double>(normals.size());
  std::vector<Eigen::Vector3d> directions;
  while (directions.size() < kMost && !normals.empty()) {
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    std::ptrdiff_t most = 0;
    for (const std::uint32_t k : random_subset(normals.size(), kCandidates, seed)) {
      const std::ptrdiff_t count =
          std::ranges::count_if(normals, [&](const auto& n) { return std::abs(n.dot(normals[k])) > within; });
      if (count > most) {
        most = count;
        best = normals[k];
      }
    }
    if (static_cast<double>(most) < needed) break;
    // The principal axis of those around it, by power iteration.
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const Eigen::Vector3d& n : normals) {
        if (std::abs(n.dot(best)) > within) sum += n.dot(best) * n;
      }
      best = sum / sum.norm();
    }
    directions.push_back(best);
    std::erase_if(normals, [&](const auto& n) { return std::abs(n.dot(best)) > beside; });
  }
  return directions;
}

/// The rotation about `axis` by the angle of this cosine and sine (Rodrigues).
Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, double cosine, double sine) {
  Eigen::Matrix3d cross;
  cross << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  return cosine * Eigen::Matrix3d::Identity() + sine * cross + (1.0 - cosine) * (axis * axis.transpose());
}

}  // namespace

Displacements::Displacements(const std::vector<SurfacePoint>& surfaces, double least, std::uint64_t seed)
    : directions_(faced_directions(surfaces, seed)), least_(least), seed_(seed) {
  // Clouds without planes are displaced as if the axes were such directions.
  if (directions_.empty()) {
    directions_ = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  }
  const auto size = static_cast<double>(surfaces.size());
  for (const SurfacePoint& s : surfaces) centre_ += Eigen::Vector3d(s.point[0], s.point[1], s.point[2]) / size;
  double squares = 0.0;
  for (const SurfacePoint& s : surfaces) {
    squares += (Eigen::Vector3d(s.point[0], s.point[1], s.point[2]) - centre_).squaredNorm() / size;
  }
  spread_ = std::sqrt(squares);
  least_ = std::max(least_, spread_ / 6.0);
  // Clouds that are hardly larger than that have to be displaced all the same.
  least_ = std::min(least_, 0.5 * spread_);
}

std::vector<RigidTransform> Displacements::of(const RigidTransform& pose, std::size_t count) const {
  const std::size_t faced = directions_.size();
  const std::size_t families = 2 * faced + faced * (faced - 1) / 2;
  const auto each = static_cast<std::uint32_t>(count / families);
  std::vector<RigidTransform> displaced;
  displaced.reserve(families * each);
  std::uint32_t family = 0;
  const auto displace = [&](const Eigen::Matrix3d& turn, const Eigen::Vector3d& shift) {
    RigidTransform other;
    other.linear() = turn * pose.linear();
    other.translation() = turn * (pose.translation() - centre_) + centre_ + shift;
    displaced.push_back(other);
  };
  for (const Eigen::Vector3d& direction : directions_) {
    const Eigen::Vector3d first = direction.unitOrthogonal();
    const Eigen::Vector3d second = direction.cross(first);
    for (const bool turned : {false, true}) {
      for (std::uint32_t k = 0; k < each; ++k) {
        Draws draws(seed_, family, k);
        for (;;) {
          const Eigen::Vector2d shift = spread_ * draws.in_disc();
          const Eigen::Vector2d half = draws.in_disc();
          double cosine = 1.0;
          double sine = 0.0;
          if (turned) {
            cosine = (half.x() * half.x() - half.y() * half.y()) / half.squaredNorm();
            sine = 2.0 * half.x() * half.y() / half.squaredNorm();
          } else if (half.x() < -0.5) {
            cosine = -1.0;
          }
          const double chord = spread_ * std::sqrt(std::max(2.0 - 2.0 * cosine, 0.0));
          if (shift.squaredNorm() + chord * chord < least_ * least_) continue;
          displace(rotation(direction, cosine, sine), shift.x() * first + shift.y() * second);
          break;
        }
      }
      ++family;
    }
  }
  for (std::size_t i = 0; i < faced; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d line = directions_[i].cross(directions_[j]).normalized();
      for (std::uint32_t k = 0; k < each; ++k) {
        const std::array<double, 4> u = Draws(seed_, family, k).next();
        const double length = least_ + u[0] * (spread_ - least_);
        displace(Eigen::Matrix3d::Identity(), (u[1] < 0.5 ? -length : length) * line);
      }
      ++family;
    }
  }
  return displaced;
}

}  // namespace consimd::features::detail
