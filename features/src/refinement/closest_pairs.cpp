#include "refinement/closest_pairs.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include <consimd/kernels/neighbourhoods.hpp>

#include "grid/cell_keys.hpp"

namespace consimd::features::detail {
namespace {

// Distances in the working frame, whose coordinates are at most 1, are known to about this.
constexpr float kRounding = 0x1p-21f;

Eigen::Vector3d vector_of(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

std::array<float, 3> point_of(const CloudView& cloud, std::size_t row) {
  return {cloud.points(0)[row], cloud.points(1)[row], cloud.points(2)[row]};
}

float distance(const std::array<float, 3>& a, const std::array<float, 3>& b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return std::sqrt(x * x + y * y + z * z);
}

/// From the working frame of the source to that of the target.
struct WorkingMotion {
  Eigen::Matrix3d linear;
  Eigen::Vector3d shift;

  WorkingMotion(const RigidTransform& pose, double source_scale, const Eigen::Vector3d& source_origin,
                const Cloud& target)
      : linear(target.scale() / source_scale * pose.linear()),
        shift(target.scale() * (pose * source_origin - vector_of(target.origin()))) {}

  std::array<float, 3> operator()(const std::array<float, 3>& p) const {
    std::array<float, 3> x{};
    for (Eigen::Index r = 0; r < 3; ++r) {
      x[static_cast<std::size_t>(r)] =
          static_cast<float>(linear(r, 0) * static_cast<double>(p[0]) + linear(r, 1) * static_cast<double>(p[1]) +
                             linear(r, 2) * static_cast<double>(p[2]) + shift[r]);
    }
    return x;
  }
};

}  // namespace

ClosestPairs::ClosestPairs(const Cloud& source, const CellGrid& target, double max_distance,
                           const RigidTransform& start)
    : target_(target),
      source_scale_(source.scale()),
      source_origin_(vector_of(source.origin())),
      max_distance_(static_cast<float>(max_distance * target.cloud().scale())),
      reach_(static_cast<float>(target.cell() * target.cloud().scale())),
      points_(source.size()),
      found_(source.size()),
      pairs_(source.size(), kNone) {
  // By the target's cells at the start, so that neighbours in the list are neighbours in the target as well.
  const WorkingMotion motion(start, source_scale_, source_origin_, target.cloud());
  constexpr double kMost = 0x1p20;
  std::vector<std::uint64_t> keys(source.size());
  const CloudView view = source.view();
  for (std::size_t row = 0; row < source.size(); ++row) {
    const std::array<float, 3> x = motion(point_of(view, row));
    for (std::size_t c = 3; c-- > 0;) {
      const double place = target.cells_along(c, x[c]);
      keys[row] = keys[row] << 21U | static_cast<std::uint64_t>(place > 0.0 ? std::min(place, kMost) + 1.0 : 0.0);
    }
  }
  rows_ = sorting_order(keys);
  sources_.reserve(rows_.size());
  for (const std::uint32_t row : rows_) sources_.push_back(point_of(view, row));
}

ClosestPairs::Found ClosestPairs::search(CellWalk& walk, const std::array<float, 3>& point, std::uint32_t guess,
                                         float gone) const {
  const CloudView target = target_.cloud().view();
  std::array<std::uint32_t, 2> nearest{kNone, kNone};
  std::array<float, 2> squared{};
  const auto look = [&](float reach) {
    const double radius = static_cast<double>(reach) / target.scale();
    return nearest_within(target, point, walk.runs_within(point, radius), radius, nearest, squared);
  };
  // The nearest is no further away than the guess. As steps become shorter the point will go about as far as it has
  // come, and may go half of the distance between the nearest and the second one: a third is wanted on top.
  constexpr float kAhead = 1.5f;
  float reach = guess == kNone
                    ? reach_
                    : std::min(reach_, distance(point, point_of(target, guess)) + kAhead * gone + 2.0f * kRounding);
  std::size_t count = look(reach);
  if (count == 0 && reach < reach_) {
    reach = reach_;
    count = look(reach);
  }
  const float first = count > 0 ? std::sqrt(squared[0]) : reach;
  const float second = count > 1 ? std::sqrt(squared[1]) : reach;
  return {point, nearest[0], count > 0 ? 0.5f * (second - first) - kRounding : -1.0f,
          first - max_distance_ - kRounding};
}

void ClosestPairs::move(const RigidTransform& T_target_source, std::size_t stride) {
  const WorkingMotion motion(T_target_source, source_scale_, source_origin_, target_.cloud());
  const CloudView target = target_.cloud().view();
  tbb::parallel_for(std::size_t{0}, (size() + kPairBlock - 1) / kPairBlock, [&](std::size_t block) {
    CellWalk walk(target_);
    const std::size_t end = std::min(size(), (block + 1) * kPairBlock);
    std::uint32_t last = kNone;  // the nearest of the entry before, a neighbour
    for (std::size_t i = block * kPairBlock; i < end; i += stride) {
      const std::array<float, 3> x = motion(sources_[i]);
      points_[i] = x;
      pairs_[i] = kNone;
      Found& found = found_[i];
      const float gone = distance(x, found.at) + kRounding;
      if (gone < found.none) continue;
      if (!(gone < found.still)) {
        found = search(walk, x, found.row == kNone ? last : found.row, found.is_known() ? gone : 0.0f);
      }
      if (found.row == kNone) continue;
      last = found.row;
      if (distance(x, point_of(target, found.row)) <= max_distance_) pairs_[i] = found.row;
    }
  });
}

}  // namespace consimd::features::detail
