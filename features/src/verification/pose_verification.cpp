#include <consimd/features/pose_verification.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <consimd/features/point_subset.hpp>
#include <consimd/kernels/elementary_functions.hpp>

#include "verification/displaced_poses.hpp"
#include "verification/observed_space.hpp"

namespace consimd::features {
namespace {

using detail::SurfacePoint;

// Samples of each cloud, and displaced poses: a pose takes 7 ms of a core with these (docs/performance.md).
constexpr std::size_t kSamples = 320;
constexpr std::size_t kDisplacements = 256;
// The share of the displaced poses whose agreement gives the tail.
constexpr double kTail = 0.05;
// Where displaced poses agree they do so in few pieces of surface: their scores vary by a quarter of themselves at
// least, as sums of sixteen pieces do.
constexpr double kPieces = 16.0;
// Scores vary by about one sample at least: one that agrees at no displaced pose counts ln 258 = 5.6.
constexpr double kLeastExcess = 5.0;
// Surfaces agree within three voxels or so, so that displacements of twice that are other poses.
constexpr double kLeastDisplacement = 6.0;
// Places that are seen through lie this many voxels before what was seen.
constexpr double kMargin = 3.0;
// What a sample that is seen through counts, in units of the logarithm that one that agrees counts: the right poses of
// lidar scans let 0.1 to 0.8 % of the samples be seen through (things that moved, and edges), displaced ones 6 to 11 %,
// and ln 10 = 2.3 is what these are apart.
constexpr double kSeenThrough = 2.0;

std::vector<SurfacePoint> samples_of(const CellGrid& surfaces, std::uint64_t seed) {
  const Cloud& cloud = surfaces.cloud();
  const CloudView view = cloud.view();
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < view.size() && view.has_normals(); ++i) {
    if (std::isfinite(view.normals(0)[i])) rows.push_back(i);
  }
  std::vector<SurfacePoint> samples;
  for (const std::uint32_t k : random_subset(rows.size(), kSamples, seed)) {
    const std::uint32_t i = rows[k];
    samples.push_back({cloud.point(i), {view.normals(0)[i], view.normals(1)[i], view.normals(2)[i]}});
  }
  return samples;
}

/// A scan as poses are held against it.
struct Side {
  detail::SurfaceMap surfaces;
  detail::FreeSpace space;
  std::vector<SurfacePoint> samples;
};

Side side_of(const VerifiedCloud& cloud, double voxel, std::uint64_t seed) {
  return {detail::SurfaceMap(cloud.surfaces, voxel),
          cloud.viewpoint ? detail::FreeSpace(cloud.scan, *cloud.viewpoint, kMargin * voxel) : detail::FreeSpace(),
          samples_of(cloud.surfaces, seed)};
}

/// What the samples of a cloud tell of one pose: sets `agrees` of each, and returns how many are seen through.
std::uint32_t look(const std::vector<SurfacePoint>& samples, const RigidTransform& pose, const Side& other,
                   std::span<std::uint8_t> agrees) {
  const Eigen::Matrix3d rotation = pose.linear();
  const Eigen::Vector3d translation = pose.translation();
  const auto moved = [&](const detail::Vector3& x, const Eigen::Vector3d& shift) {
    const Eigen::Vector3d y = rotation * Eigen::Vector3d(x[0], x[1], x[2]) + shift;
    return detail::Vector3{y.x(), y.y(), y.z()};
  };
  std::uint32_t seen_through = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const SurfacePoint place{moved(samples[i].point, translation), moved(samples[i].normal, Eigen::Vector3d::Zero())};
    const detail::Agreement agreement = other.surfaces.agreement(place);
    agrees[i] = agreement == detail::Agreement::surface ? 1 : 0;
    if (agreement == detail::Agreement::empty && other.space.seen_through(place.point)) ++seen_through;
  }
  return seen_through;
}

}  // namespace

struct PoseVerifier::Clouds {
  Side source;
  Side target;
  detail::Displacements displacements;

  [[nodiscard]] std::size_t samples() const noexcept { return source.samples.size() + target.samples.size(); }

  /// agrees: of the source's samples, then of the target's.
  std::uint32_t look_both_ways(const RigidTransform& pose, std::span<std::uint8_t> agrees) const {
    const std::size_t n = source.samples.size();
    return look(source.samples, pose, target, agrees.first(n)) +
           look(target.samples, pose.inverse(), source, agrees.subspan(n));
  }
};

PoseVerifier::PoseVerifier(const VerifiedCloud& source, const VerifiedCloud& target, double voxel, std::uint64_t seed) {
  if (!(std::isfinite(voxel) && voxel > 0.0)) {
    throw std::invalid_argument("voxel is " + std::to_string(voxel) + ", expected a length above 0");
  }
  for (const auto& [name, cloud] : {std::pair("source", &source), std::pair("target", &target)}) {
    if (cloud->viewpoint && !std::ranges::all_of(*cloud->viewpoint, [](double x) { return std::isfinite(x); })) {
      throw std::invalid_argument(std::string("the viewpoint of the ") + name + " is not finite");
    }
  }
  std::optional<Side> of_source, of_target;
  tbb::parallel_invoke([&] { of_source = side_of(source, voxel, seed); },
                       [&] { of_target = side_of(target, voxel, seed); });
  const detail::Displacements displacements(of_target->samples, kLeastDisplacement * voxel, seed);
  clouds_ = std::make_unique<Clouds>(Clouds{std::move(*of_source), std::move(*of_target), displacements});
}

PoseVerifier::~PoseVerifier() = default;
PoseVerifier::PoseVerifier(PoseVerifier&&) noexcept = default;
PoseVerifier& PoseVerifier::operator=(PoseVerifier&&) noexcept = default;

PoseEvidence PoseVerifier::evidence(const RigidTransform& T_target_source) const {
  if (!T_target_source.matrix().allFinite()) throw std::invalid_argument("T_target_source is not finite");
  PoseEvidence result;
  if (clouds_->source.samples.empty() || clouds_->target.samples.empty()) return result;

  std::vector<RigidTransform> poses = clouds_->displacements.of(T_target_source, kDisplacements);
  poses.push_back(T_target_source);
  result.samples = clouds_->samples();
  result.displacements = poses.size() - 1;
  std::vector<std::uint8_t> agrees(poses.size() * result.samples);  // of pose, sample
  std::vector<std::uint32_t> seen_through(poses.size());
  const auto agrees_of = [&](std::size_t pose) {
    return std::span(agrees).subspan(pose * result.samples, result.samples);
  };
  tbb::parallel_for(std::size_t{0}, poses.size(),
                    [&](std::size_t k) { seen_through[k] = clouds_->look_both_ways(poses[k], agrees_of(k)); });

  const std::size_t displaced = result.displacements;
  const auto samples = static_cast<double>(result.samples);
  result.agreement = static_cast<double>(std::ranges::count(agrees_of(displaced), 1)) / samples;
  result.seen_through = static_cast<double>(seen_through[displaced]) / samples;

  // A sample's weight is the logarithm of how rarely it agrees.
  std::vector<std::uint32_t> agreeing(result.samples);
  for (std::size_t k = 0; k < displaced; ++k) {
    for (std::size_t i = 0; i < agreeing.size(); ++i) agreeing[i] += agrees_of(k)[i];
  }
  std::vector<double> weights(result.samples);
  std::ranges::transform(agreeing, weights.begin(), [displaced](std::uint32_t count) {
    return elementary::log(static_cast<double>(displaced + 2) / static_cast<double>(count + 1));
  });
  const auto score = [&](std::size_t pose) {
    const std::span<const std::uint8_t> of_pose = agrees_of(pose);
    double sum = -kSeenThrough * static_cast<double>(seen_through[pose]);
    for (std::size_t i = 0; i < weights.size(); ++i) sum += static_cast<double>(of_pose[i]) * weights[i];
    return sum;
  };
  std::vector<double> scores(displaced);
  for (std::size_t k = 0; k < displaced; ++k) scores[k] = score(k);
  std::ranges::sort(scores, std::greater<>());
  const double reached = score(displaced);
  const auto tail = static_cast<std::size_t>(kTail * static_cast<double>(scores.size()));
  const double threshold = scores[tail];
  if (reached <= threshold) {
    const auto better = std::ranges::count_if(scores, [reached](double s) { return s >= reached; });
    result.log10_chance = elementary::log10(static_cast<double>(better + 1) / static_cast<double>(scores.size() + 1));
    return result;
  }
  double excess = 0.0;
  for (std::size_t k = 0; k < tail; ++k) excess += (scores[k] - threshold) / static_cast<double>(tail);
  excess = std::max({excess, threshold / std::sqrt(kPieces), kLeastExcess});
  result.log10_chance = elementary::log10(kTail) - (reached - threshold) / (excess * std::numbers::ln10);
  return result;
}

}  // namespace consimd::features
