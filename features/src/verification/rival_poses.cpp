#include "verification/rival_poses.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <numbers>
#include <span>

#include <consimd/kernels/elementary_functions.hpp>

#include "verification/surface_fit.hpp"

namespace consimd::features::detail {
namespace {

// Steps of shifts and turns, in voxels: the nearest shift is 2.1 voxels from a peak at most, and coarse surfaces agree
// across 2 and along 3.
constexpr double kStep = 3.0;
// Steps that a pose is shifted by at most, and turns of a full one: beyond a spread of 160 voxels these are further
// apart than a step.
constexpr int kFarthest = 32;
constexpr int kMostTurns = 512;
// Share of the samples that agree at a peak. Of the first few one has to, of the first some a quarter, which they do at
// 88 % of such peaks.
constexpr double kLeastShare = 0.4;
constexpr std::size_t kFew = 5;
constexpr std::size_t kSome = 16;
// Samples that are each shifted to surfaces of the target, and how many of these at most, at even distances. Of 16
// pairs of like objects each alone in a scan one sample is enough in all; some may lie on what stands beside. All this
// takes 1.08 times the time of a verification.
constexpr std::size_t kShiftedSamples = 4;
constexpr std::size_t kLikeSurfaces = 4096;
constexpr std::size_t kOfEachFamily = 3;
constexpr std::size_t kShiftedPeaks = 8;
constexpr std::size_t kTurnedPeaks = 4;
// Surfaces agree within three voxels or so, and a pose has slid to another peak beyond twice that.
constexpr double kAnother = 6.0;

/// The middle of each run of equal counts that those beside it are below, in a circle; of equal ones all around, the
/// quarters of it. Not the first one, which is the pose itself.
std::vector<std::size_t> peaks_around(const std::vector<std::size_t>& counts) {
  const std::size_t size = counts.size();
  if (std::ranges::all_of(counts, [&](std::size_t c) { return c == counts[0]; })) {
    return {size / 2, size / 4, size - size / 4};
  }
  std::vector<std::size_t> peaks;
  for (std::size_t k = 0; k < size; ++k) {
    if (counts[k] <= counts[(k + size - 1) % size]) continue;
    std::size_t run = 1;
    while (counts[(k + run) % size] == counts[k]) ++run;
    const std::size_t middle = (k + run / 2) % size;
    if (counts[(k + run) % size] < counts[k] && middle != 0) peaks.push_back(middle);
  }
  return peaks;
}

}  // namespace

template <typename Place>
std::size_t RivalSearch::agreeing(std::size_t samples, const Place& place) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    if ((i == kFew && count == 0) || (i == kSome && 4 * count < kSome)) return 0;
    if (coarse_.agreement(place(i)) == Agreement::surface) ++count;
  }
  return count;
}

std::vector<RivalSearch::Peak> RivalSearch::shifted(const RigidTransform& pose,
                                                    const std::vector<SurfacePoint>& telling,
                                                    const Eigen::Vector3d& direction, int quarter_turns) const {
  constexpr double kCosine[] = {1.0, 0.0, -1.0, 0.0};
  constexpr double kSine[] = {0.0, 1.0, 0.0, -1.0};
  const RigidTransform turned_pose =
      turned_about(layout_.centre, direction, kCosine[quarter_turns], kSine[quarter_turns], pose);
  std::vector<SurfacePoint> surfaces;
  surfaces.reserve(telling.size());
  for (const SurfacePoint& surface : telling) surfaces.push_back(placed({turned_pose, 1.0}, surface));
  const double step = kStep * voxel_;
  const Eigen::Vector3d first = step * direction.unitOrthogonal();
  const Eigen::Vector3d second = direction.cross(first);
  const int reach = static_cast<int>(std::clamp(layout_.spread / step, 2.0, static_cast<double>(kFarthest)));
  // The grid has a margin, where nothing agrees.
  const int width = 2 * reach + 3;
  std::vector<std::size_t> counts(static_cast<std::size_t>(width) * static_cast<std::size_t>(width));
  const auto at = [&](int a, int b) -> std::size_t& {
    return counts[static_cast<std::size_t>(b + reach + 1) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(a + reach + 1)];
  };
  const auto visit = [&](const auto& place) {
    for (int b = -reach; b <= reach; ++b) {
      for (int a = -reach; a <= reach; ++a) {
        if (a * a + b * b <= reach * reach) place(a, b);
      }
    }
  };
  visit([&](int a, int b) {
    const Eigen::Vector3d shift = a * first + b * second;
    at(a, b) = agreeing(surfaces.size(), [&](std::size_t i) {
      SurfacePoint place = surfaces[i];
      for (std::size_t c = 0; c < 3; ++c) place.point[c] += shift[static_cast<Eigen::Index>(c)];
      return place;
    });
  });
  std::vector<Peak> peaks;
  visit([&](int a, int b) {
    const std::size_t count = at(a, b);
    if (static_cast<double>(count) < kLeastShare * static_cast<double>(surfaces.size())) return;
    if (quarter_turns == 0 && a == 0 && b == 0) return;
    // Of equal neighbours the last one is the peak.
    for (int j = -1; j <= 1; ++j) {
      for (int i = -1; i <= 1; ++i) {
        const bool later = j > 0 || (j == 0 && i > 0);
        if ((i != 0 || j != 0) && (later ? at(a + i, b + j) >= count : at(a + i, b + j) > count)) return;
      }
    }
    RigidTransform peak = turned_pose;
    peak.translation() += a * first + b * second;
    peaks.emplace_back(count, peak);
  });
  return peaks;
}

// A shift between two like objects may have any direction. It takes every sample on one of them to a surface of the
// other, so that a few samples are enough to meet it.
std::vector<RivalSearch::Peak> RivalSearch::shifted_to_like(const RigidTransform& pose,
                                                            const std::vector<SurfacePoint>& telling) const {
  std::vector<SurfacePoint> surfaces;
  surfaces.reserve(telling.size());
  for (const SurfacePoint& surface : telling) surfaces.push_back(placed({pose, 1.0}, surface));
  const std::span<const SurfacePoint> like = coarse_.surfaces();
  const std::size_t stride = 1 + like.size() / kLikeSurfaces;
  std::vector<Peak> peaks;
  for (std::size_t s = 0; s < std::min(kShiftedSamples, surfaces.size()); ++s) {
    const SurfacePoint& sample = surfaces[s * surfaces.size() / kShiftedSamples];
    for (std::size_t j = 0; j < like.size(); j += stride) {
      if (!of_like_orientation(sample, like[j])) continue;
      Vector3 shift;
      for (std::size_t c = 0; c < 3; ++c) shift[c] = like[j].point[c] - sample.point[c];
      if (dot(shift, shift) <= kAnother * kAnother * voxel_ * voxel_) continue;
      const std::size_t count = agreeing(surfaces.size(), [&](std::size_t i) {
        SurfacePoint place = surfaces[i];
        for (std::size_t c = 0; c < 3; ++c) place.point[c] += shift[c];
        return place;
      });
      if (static_cast<double>(count) < kLeastShare * static_cast<double>(surfaces.size())) continue;
      RigidTransform peak = pose;
      peak.translation() += vector(shift);
      peaks.emplace_back(count, peak);
    }
  }
  return peaks;
}

std::vector<RivalSearch::Peak> RivalSearch::turned(const RigidTransform& pose, const std::vector<SurfacePoint>& telling,
                                                   const Eigen::Vector3d& axis) const {
  // Half of the surfaces lie less than their spread from the centre, few beyond 1.5 times that.
  const double around = 2.0 * std::numbers::pi * 1.5 * layout_.spread / (kStep * voxel_);
  const auto turns = static_cast<std::size_t>(std::clamp(around, 12.0, static_cast<double>(kMostTurns)));
  const auto turned_by = [&](std::size_t k) {
    const auto [sine, cosine] =
        elementary::sine_cosine(2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(turns));
    return turned_about(layout_.centre, axis, cosine, sine, pose);
  };
  std::vector<std::size_t> counts(turns);
  for (std::size_t k = 0; k < turns; ++k) {
    const ScaledPose there{turned_by(k), 1.0};
    counts[k] = agreeing(telling.size(), [&](std::size_t i) { return placed(there, telling[i]); });
  }
  std::vector<Peak> peaks;
  for (const std::size_t k : peaks_around(counts)) {
    if (static_cast<double>(counts[k]) >= kLeastShare * static_cast<double>(telling.size())) {
      peaks.emplace_back(counts[k], turned_by(k));
    }
  }
  return peaks;
}

std::vector<RigidTransform> RivalSearch::peaks(const RigidTransform& pose,
                                               const std::vector<SurfacePoint>& telling) const {
  std::vector<Eigen::Vector3d> axes = layout_.faced;
  axes.insert(axes.end(), layout_.principal.begin(), layout_.principal.end());
  // By quarters about the first direction, by half turns about the others, which saves a third of the time: a floor
  // that is brought onto a wall is one of an object, whose turns about its centre are tried in any case.
  std::vector<std::pair<Eigen::Vector3d, int>> shifts;
  for (std::size_t d = 0; d < layout_.faced.size(); ++d) {
    for (int quarters = 0; quarters < 4; quarters += d == 0 ? 1 : 2) shifts.emplace_back(layout_.faced[d], quarters);
  }
  // Shifts across the directions, the others, turns.
  const std::size_t all_shifts = shifts.size() + 1;
  std::vector<std::vector<Peak>> families(all_shifts + axes.size());
  const auto higher = [](const Peak& a, const Peak& b) { return a.first > b.first; };
  tbb::parallel_for(std::size_t{0}, families.size(), [&](std::size_t f) {
    std::vector<Peak> found;
    if (f < shifts.size()) {
      found = shifted(pose, telling, shifts[f].first, shifts[f].second);
    } else if (f < all_shifts) {
      found = shifted_to_like(pose, telling);
    } else {
      found = turned(pose, telling, axes[f - all_shifts]);
    }
    std::ranges::stable_sort(found, higher);
    for (const Peak& peak : found) {
      if (families[f].size() == kOfEachFamily) break;
      const auto is_known = [&](const Peak& known) { return !is_another(known.second, peak.second); };
      if (is_another(pose, peak.second) && std::ranges::none_of(families[f], is_known)) families[f].push_back(peak);
    }
  });
  // The highest of each kind are taken: on a surface that resembles itself many shifts are as high as the turns about
  // its axis.
  std::vector<RigidTransform> poses;
  const auto add_highest = [&](std::size_t begin, std::size_t end, std::size_t most) {
    std::vector<Peak> found;
    for (std::size_t f = begin; f < end; ++f) found.insert(found.end(), families[f].begin(), families[f].end());
    std::ranges::stable_sort(found, higher);
    for (std::size_t k = 0; k < std::min(most, found.size()); ++k) poses.push_back(found[k].second);
  };
  add_highest(0, all_shifts, kShiftedPeaks);
  add_highest(all_shifts, families.size(), kTurnedPeaks);
  return poses;
}

bool RivalSearch::is_another(const RigidTransform& pose, const RigidTransform& other) const {
  const RigidTransform between = other * pose.inverse();
  const Eigen::Matrix3d turn = between.linear() - Eigen::Matrix3d::Identity();
  const double squared =
      (between * layout_.centre - layout_.centre).squaredNorm() + (turn * layout_.scatter * turn.transpose()).trace();
  return squared > kAnother * kAnother * voxel_ * voxel_;
}

}  // namespace consimd::features::detail
