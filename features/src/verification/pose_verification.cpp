#include <consimd/features/pose_verification.hpp>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <consimd/features/cloud_verdict.hpp>
#include <consimd/features/point_subset.hpp>
#include <consimd/kernels/elementary_functions.hpp>

#include "verification/displaced_poses.hpp"
#include "verification/observed_space.hpp"
#include "verification/rival_poses.hpp"
#include "verification/surface_fit.hpp"
#include "verification/surface_layout.hpp"

namespace consimd::features {
namespace {

using detail::SurfacePoint;

// Samples of each cloud, and displaced poses: a pose takes 7 to 11 ms of a core with these (docs/performance.md).
constexpr std::size_t kSamples = 320;
constexpr std::size_t kDisplacements = 256;
// The share of the displaced poses whose agreement gives the tail.
constexpr double kTail = 0.05;
// Where displaced poses agree they do so in few pieces of surface: their scores vary by a quarter of themselves at
// least, as sums of sixteen pieces do.
constexpr double kPieces = 16.0;
// Scores vary by about one sample at least: one that agrees at no displaced pose counts ln 258 = 5.6.
constexpr double kLeastExcess = 5.0;
// Poses of less are compared with no other: their share of so little tells nothing.
constexpr double kLeastScore = 2.0 * kLeastExcess;
// Surfaces agree within three voxels or so, so that displacements of twice that are other poses.
constexpr double kLeastDisplacement = 6.0;
// Places that are seen through lie this many voxels before what was seen.
constexpr double kMargin = 3.0;
// What a sample that is seen through counts, in units of the logarithm that one that agrees counts: the right poses of
// lidar scans let 0.1 to 0.8 % of the samples be seen through (things that moved, and edges), displaced ones 6 to 11 %,
// and ln 10 = 2.3 is what these are apart.
constexpr double kSeenThroughWeight = 2.0;
// Samples that rivals are looked for with, the rarest of those that agree, and displaced poses that are tried for one.
constexpr std::size_t kTelling = 64;
constexpr std::size_t kBestDisplaced = 2;
// Voxels from a plane at which a fitted surface is another one: at right poses of recorded scans the root mean square
// is 0.15 to 0.35. With a whole voxel 7 of 28 round objects of 1000 and 2000 points had an equal rival, with half of
// one none; of 288 pairs of repeating scenes 2 more stayed a success.
constexpr double kClose = 0.5;

std::vector<SurfacePoint> samples_of(std::span<const SurfacePoint> surfaces, std::uint64_t seed) {
  std::vector<SurfacePoint> samples;
  for (const std::uint32_t k : random_subset(surfaces.size(), kSamples, seed)) samples.push_back(surfaces[k]);
  return samples;
}

/// A scan as poses are held against it.
struct Side {
  detail::SurfaceMap surfaces;
  detail::FreeSpace space;
  std::vector<SurfacePoint> samples;
};

detail::FreeSpace space_of(const VerifiedCloud& cloud, double voxel) {
  return cloud.viewpoint ? detail::FreeSpace(cloud.scan, *cloud.viewpoint, kMargin * voxel) : detail::FreeSpace();
}

Side side_of(std::vector<SurfacePoint> surfaces, detail::FreeSpace space, double voxel, std::uint64_t seed) {
  std::vector<SurfacePoint> samples = samples_of(surfaces, seed);
  return {detail::SurfaceMap(std::move(surfaces), voxel), std::move(space), std::move(samples)};
}

/// What the samples of a cloud, kSamples at most, tell of one pose: sets `agrees` of each, and returns how many are
/// seen through.
std::uint32_t look(const std::vector<SurfacePoint>& samples, const RigidTransform& pose, const Side& other,
                   std::span<std::uint8_t> agrees) {
  std::array<SurfacePoint, kSamples> places;
  std::array<detail::Agreement, kSamples> found;
  const std::size_t count = samples.size();
  for (std::size_t i = 0; i < count; ++i) places[i] = detail::placed({pose, 1.0}, samples[i]);
  other.surfaces.agreements(std::span(places).first(count), std::span(found).first(count));
  std::size_t empty = 0;
  for (std::size_t i = 0; i < count; ++i) {
    agrees[i] = found[i] == detail::Agreement::surface ? 1 : 0;
    places[empty] = places[i];
    empty += found[i] == detail::Agreement::empty ? 1U : 0U;
  }
  return other.space.count_seen_through(std::span(places).first(empty));
}

/// The weights of the samples that agree, each less the further it is from the surface's plane (Tukey's biweight, of
/// the width of half a voxel): surfaces that curve otherwise pass near one another, but are not the same.
double closeness(const std::vector<SurfacePoint>& samples, const detail::ScaledPose& pose,
                 const detail::SurfaceMap& surfaces, std::span<const double> weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double near = 1.0 - surfaces.squared_distance(detail::placed(pose, samples[i])) / (kClose * kClose);
    if (near > 0.0) sum += weights[i] * near * near;
  }
  return sum;
}

/// What all samples tell of some poses.
struct Looks {
  Looks(std::size_t poses, std::size_t samples_of_each)
      : samples(samples_of_each), flags(poses * samples_of_each), seen_through(poses) {}

  [[nodiscard]] std::span<std::uint8_t> agrees(std::size_t pose) {
    return std::span(flags).subspan(pose * samples, samples);
  }
  [[nodiscard]] std::span<const std::uint8_t> agrees(std::size_t pose) const {
    return std::span(flags).subspan(pose * samples, samples);
  }
  [[nodiscard]] std::size_t agreeing(std::size_t pose) const {
    return static_cast<std::size_t>(std::ranges::count(agrees(pose), 1));
  }
  /// weights: of the samples.
  [[nodiscard]] double score(std::size_t pose, std::span<const double> weights) const {
    const std::span<const std::uint8_t> of_pose = agrees(pose);
    double sum = -kSeenThroughWeight * static_cast<double>(seen_through[pose]);
    for (std::size_t i = 0; i < weights.size(); ++i) sum += static_cast<double>(of_pose[i]) * weights[i];
    return sum;
  }

  std::size_t samples;
  std::vector<std::uint8_t> flags;  // of pose, sample
  std::vector<std::uint32_t> seen_through;
};

/// The logarithm of how rarely each sample agrees at the first so many poses.
std::vector<double> weights_of(const Looks& looks, std::size_t displaced) {
  std::vector<std::uint32_t> agreeing(looks.samples);
  for (std::size_t k = 0; k < displaced; ++k) {
    for (std::size_t i = 0; i < agreeing.size(); ++i) agreeing[i] += looks.agrees(k)[i];
  }
  std::vector<double> weights(looks.samples);
  std::ranges::transform(agreeing, weights.begin(), [displaced](std::uint32_t count) {
    return elementary::log(static_cast<double>(displaced + 2) / static_cast<double>(count + 1));
  });
  return weights;
}

/// log10 of the chance of a score among those of displaced poses, the highest first.
double log10_chance_of(double reached, const std::vector<double>& scores) {
  const auto tail = static_cast<std::size_t>(kTail * static_cast<double>(scores.size()));
  const double threshold = scores[tail];
  if (reached <= threshold) {
    const auto better = std::ranges::count_if(scores, [reached](double s) { return s >= reached; });
    return elementary::log10(static_cast<double>(better + 1) / static_cast<double>(scores.size() + 1));
  }
  double excess = 0.0;
  for (std::size_t k = 0; k < tail; ++k) excess += (scores[k] - threshold) / static_cast<double>(tail);
  excess = std::max({excess, threshold / std::sqrt(kPieces), kLeastExcess});
  return elementary::log10(kTail) - (reached - threshold) / (excess * std::numbers::ln10);
}

void require_finite(const RigidTransform& T_target_source) {
  if (!T_target_source.matrix().allFinite()) throw std::invalid_argument("T_target_source is not finite");
}

/// The first rows of an order, by falling value.
template <typename Values>
std::vector<std::size_t> highest(const Values& values, std::vector<std::size_t> rows, std::size_t count) {
  std::ranges::stable_sort(rows, [&](std::size_t a, std::size_t b) { return values[a] > values[b]; });
  if (rows.size() > count) rows.resize(count);
  return rows;
}

/// A pose fitted to the surfaces, and its rivals, the best first.
struct Fits {
  double agreement = 0.0;
  double seen_through = 0.0;
  std::vector<RivalPose> rivals;
};

}  // namespace

struct PoseVerifier::Clouds {
  Side source;
  Side target;
  detail::SurfaceMap coarse;     // of the target
  detail::SurfaceLayout layout;  // of the target
  double voxel;
  std::uint64_t seed;

  /// What the source's samples, then the target's, tell of each pose.
  [[nodiscard]] Looks look_both_ways(const std::vector<RigidTransform>& poses) const {
    Looks looks(poses.size(), source.samples.size() + target.samples.size());
    tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t k) {
      const std::span<std::uint8_t> agrees = looks.agrees(k);
      const std::size_t n = source.samples.size();
      looks.seen_through[k] = look(source.samples, poses[k], target, agrees.first(n)) +
                              look(target.samples, poses[k].inverse(), source, agrees.subspan(n));
    });
    return looks;
  }

  [[nodiscard]] detail::FittedSurfaces fitted_surfaces() const { return {coarse, target.surfaces, layout, voxel}; }

  [[nodiscard]] RigidTransform fitted_rigidly(const RigidTransform& pose) const {
    return detail::fitted(fitted_surfaces(), source.samples, pose, detail::Freedom::rigid).T_target_source;
  }
  /// How closely the surfaces agree, and what is seen through against that. weights: of the samples.
  [[nodiscard]] double score(const RigidTransform& pose, std::uint32_t seen_through,
                             std::span<const double> weights) const {
    const std::size_t n = source.samples.size();
    return closeness(source.samples, {pose, 1.0}, target.surfaces, weights.first(n)) +
           closeness(target.samples, {pose.inverse(), 1.0}, source.surfaces, weights.subspan(n)) -
           kSeenThroughWeight * static_cast<double>(seen_through);
  }
  /// Fits the pose to the surfaces, and the other poses that are peaks of the agreement or of the most likely displaced
  /// ones. agrees: which samples agree at the pose. candidates: other poses to begin at besides the peaks.
  [[nodiscard]] Fits fits_of(const RigidTransform& pose, std::vector<RigidTransform> candidates,
                             std::span<const std::uint8_t> agrees, std::span<const double> weights) const;
  [[nodiscard]] ScaledFit scaled_fit_of(const RigidTransform& pose, std::span<const double> weights) const;
};

Fits PoseVerifier::Clouds::fits_of(const RigidTransform& pose, std::vector<RigidTransform> candidates,
                                   std::span<const std::uint8_t> agrees, std::span<const double> weights) const {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < source.samples.size(); ++i) {
    if (agrees[i] != 0) rows.push_back(i);
  }
  std::vector<SurfacePoint> telling;
  for (const std::size_t i : highest(weights, std::move(rows), kTelling)) telling.push_back(source.samples[i]);
  const detail::RivalSearch search(coarse, layout, voxel);
  const std::vector<RigidTransform> peaks = search.peaks(pose, telling);
  candidates.insert(candidates.begin(), peaks.begin(), peaks.end());
  candidates.push_back(pose);
  tbb::parallel_for(std::size_t{0}, candidates.size(),
                    [&](std::size_t k) { candidates[k] = fitted_rigidly(candidates[k]); });
  // A fit may slide along what no surface holds.
  const RigidTransform reference = search.is_another(pose, candidates.back()) ? pose : candidates.back();
  candidates.pop_back();
  std::erase_if(candidates, [&](const RigidTransform& other) {
    return !search.is_another(pose, other) || !search.is_another(reference, other);
  });
  candidates.push_back(reference);

  const Looks looks = look_both_ways(candidates);
  std::vector<double> scores(candidates.size());
  for (std::size_t k = 0; k < candidates.size(); ++k) scores[k] = score(candidates[k], looks.seen_through[k], weights);
  const double of_pose = scores.back();
  const auto samples = static_cast<double>(looks.samples);
  const auto agreeing_at_pose = static_cast<double>(looks.agreeing(candidates.size() - 1));
  Fits fits{agreeing_at_pose / samples, static_cast<double>(looks.seen_through.back()) / samples, {}};
  if (of_pose < kLeastScore) return fits;
  std::vector<std::size_t> others(candidates.size() - 1);
  std::iota(others.begin(), others.end(), std::size_t{0});
  for (const std::size_t k : highest(scores, std::move(others), candidates.size())) {
    fits.rivals.push_back({.T_target_source = candidates[k],
                           .share_of_score = scores[k] / of_pose,
                           .share_of_agreement = static_cast<double>(looks.agreeing(k)) / agreeing_at_pose,
                           .agreement = static_cast<double>(looks.agreeing(k)) / samples,
                           .seen_through = static_cast<double>(looks.seen_through[k]) / samples});
  }
  return fits;
}

ScaledFit PoseVerifier::Clouds::scaled_fit_of(const RigidTransform& pose, std::span<const double> weights) const {
  const std::span<const double> of_source = weights.first(source.samples.size());
  const auto closeness_of = [&](detail::Freedom freedom, ScaledFit& fit) {
    const detail::ScaledPose found = detail::fitted(fitted_surfaces(), source.samples, pose, freedom);
    fit.scale = found.scale;
    return closeness(source.samples, found, target.surfaces, of_source);
  };
  ScaledFit fit;
  const double rigid = closeness_of(detail::Freedom::rigid, fit);
  const double scaled = closeness_of(detail::Freedom::scaled, fit);
  if (rigid < kLeastScore || scaled <= rigid) return {};
  fit.gain = scaled / rigid;
  return fit;
}

PoseVerifier::PoseVerifier(const VerifiedCloud& source, const VerifiedCloud& target, double voxel, std::uint64_t seed) {
  if (!(std::isfinite(voxel) && voxel > 0.0)) {
    throw std::invalid_argument("voxel is " + std::to_string(voxel) + ", expected a length above 0");
  }
  for (const auto& [name, cloud] : {std::pair("source", &source), std::pair("target", &target)}) {
    if (cloud->viewpoint && !std::ranges::all_of(*cloud->viewpoint, [](double x) { return std::isfinite(x); })) {
      throw std::invalid_argument(std::string("the viewpoint of the ") + name + " is not finite");
    }
  }
  detail::FreeSpace source_space, target_space;
  std::vector<SurfacePoint> source_surfaces, target_surfaces;
  const auto see = [voxel](const VerifiedCloud& cloud, detail::FreeSpace& space, std::vector<SurfacePoint>& surfaces) {
    space = space_of(cloud, voxel);
    surfaces = detail::surface_points(cloud.surfaces, space);
  };
  tbb::parallel_invoke([&] { see(source, source_space, source_surfaces); },
                       [&] { see(target, target_space, target_surfaces); });
  std::optional<Side> of_source, of_target;
  std::optional<detail::SurfaceMap> coarse;
  tbb::parallel_invoke([&] { of_source = side_of(std::move(source_surfaces), std::move(source_space), voxel, seed); },
                       [&] { of_target = side_of(target_surfaces, std::move(target_space), voxel, seed); },
                       [&] { coarse.emplace(target_surfaces, voxel, detail::RivalSearch::kCoarse); });
  detail::SurfaceLayout layout = detail::layout_of(of_target->surfaces.surfaces(), of_target->samples, seed);
  clouds_ = std::make_unique<Clouds>(
      Clouds{std::move(*of_source), std::move(*of_target), std::move(*coarse), std::move(layout), voxel, seed});
}

PoseVerifier::~PoseVerifier() = default;
PoseVerifier::PoseVerifier(PoseVerifier&&) noexcept = default;
PoseVerifier& PoseVerifier::operator=(PoseVerifier&&) noexcept = default;

RigidTransform PoseVerifier::fitted(const RigidTransform& T_target_source) const {
  require_finite(T_target_source);
  return clouds_->fitted_rigidly(T_target_source);
}

bool PoseVerifier::are_alike(const RigidTransform& pose, const RigidTransform& other) const {
  require_finite(pose);
  require_finite(other);
  return !detail::RivalSearch(clouds_->coarse, clouds_->layout, clouds_->voxel).is_another(pose, other);
}

PoseEvidence PoseVerifier::evidence(const RigidTransform& T_target_source) const {
  require_finite(T_target_source);
  PoseEvidence result;
  if (clouds_->source.samples.empty() || clouds_->target.samples.empty()) return result;

  const detail::Displacements displacements(clouds_->layout, kLeastDisplacement * clouds_->voxel, clouds_->seed);
  std::vector<RigidTransform> poses = displacements.of(T_target_source, kDisplacements);
  poses.push_back(T_target_source);
  const std::size_t displaced = poses.size() - 1;
  const Looks looks = clouds_->look_both_ways(poses);
  const auto samples = static_cast<double>(looks.samples);
  result.samples = looks.samples;
  result.displacements = displaced;
  result.agreement = static_cast<double>(looks.agreeing(displaced)) / samples;
  result.seen_through = static_cast<double>(looks.seen_through[displaced]) / samples;
  for (std::size_t k = 0; k < displaced; ++k) {
    result.displaced_agreement += static_cast<double>(looks.agreeing(k)) / (samples * static_cast<double>(displaced));
    result.displaced_seen_through +=
        static_cast<double>(looks.seen_through[k]) / (samples * static_cast<double>(displaced));
  }

  const std::vector<double> weights = weights_of(looks, displaced);
  std::vector<double> scores(poses.size());
  for (std::size_t k = 0; k < poses.size(); ++k) scores[k] = looks.score(k, weights);
  std::vector<double> of_displaced(scores.begin(), scores.end() - 1);
  std::ranges::sort(of_displaced, std::greater<>());
  result.log10_chance = log10_chance_of(scores.back(), of_displaced);
  if (result.log10_chance < elementary::log10(kTail)) {
    std::vector<std::size_t> all(displaced);
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<RigidTransform> candidates;
    for (const std::size_t k : highest(scores, std::move(all), kBestDisplaced)) candidates.push_back(poses[k]);
    const Fits fits = clouds_->fits_of(T_target_source, std::move(candidates), looks.agrees(displaced), weights);
    result.fitted_agreement = fits.agreement;
    result.fitted_seen_through = fits.seen_through;
    // The best one, unless another is as good as the pose by what is seen through.
    for (const RivalPose& rival : fits.rivals) {
      PoseEvidence with_rival = result;
      with_rival.rival = rival;
      const bool is_equal = has_equal_rival(with_rival);
      if (is_equal || !result.rival) result.rival = rival;
      if (is_equal) break;
    }
    result.scaled = clouds_->scaled_fit_of(T_target_source, weights);
  }
  return result;
}

}  // namespace consimd::features
