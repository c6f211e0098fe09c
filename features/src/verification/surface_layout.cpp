#include "verification/surface_layout.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <consimd/features/point_subset.hpp>

namespace consimd::features::detail {
namespace {

/// The next direction is sought among normals that are more than 30 degrees from those before.
std::vector<Eigen::Vector3d> faced_directions(const std::vector<SurfacePoint>& surfaces, std::uint64_t seed) {
  constexpr std::size_t kMost = 3;
  constexpr std::size_t kCandidates = 64;
  constexpr double kShare = 0.05;
  const double within = std::sqrt(0.5 + 0.25 * std::sqrt(3.0));  // cos 15 degrees
  const double beside = 0.5 * std::sqrt(3.0);                    // cos 30 degrees
  std::vector<Eigen::Vector3d> normals;
  normals.reserve(surfaces.size());
  for (const SurfacePoint& surface : surfaces) normals.push_back(vector(surface.normal));
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
  if (directions.empty()) {
    directions = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()};
  }
  return directions;
}

}  // namespace

SurfaceLayout layout_of(std::span<const SurfacePoint> surfaces, const std::vector<SurfacePoint>& samples,
                        std::uint64_t seed) {
  SurfaceLayout layout;
  layout.faced = faced_directions(samples, seed);
  const auto size = static_cast<double>(surfaces.size());
  for (const SurfacePoint& s : surfaces) layout.centre += vector(s.point) / size;
  for (const SurfacePoint& s : surfaces) {
    const Eigen::Vector3d offset = vector(s.point) - layout.centre;
    layout.scatter += offset * offset.transpose() / size;
  }
  layout.spread = std::sqrt(layout.scatter.trace());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(layout.scatter);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d axis = axes.eigenvectors().col(k);
    constexpr double kSame = 0.995;  // cosine of 6 degrees
    if (std::ranges::none_of(layout.faced, [&](const auto& d) { return std::abs(d.dot(axis)) > kSame; })) {
      layout.principal.push_back(axis);
    }
  }
  return layout;
}

RigidTransform turned_about(const Eigen::Vector3d& centre, const Eigen::Vector3d& axis, double cosine, double sine,
                            const RigidTransform& pose) {
  Eigen::Matrix3d cross;
  cross << 0.0, -axis.z(), axis.y(), axis.z(), 0.0, -axis.x(), -axis.y(), axis.x(), 0.0;
  const Eigen::Matrix3d turn =
      cosine * Eigen::Matrix3d::Identity() + sine * cross + (1.0 - cosine) * (axis * axis.transpose());
  RigidTransform result;
  result.linear() = turn * pose.linear();
  result.translation() = turn * (pose.translation() - centre) + centre;
  return result;
}

}  // namespace consimd::features::detail
