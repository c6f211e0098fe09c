#include "refinement/closest_pairs.hpp"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <consimd/kernels/neighbourhoods.hpp>
#include <consimd/kernels/pair_equations.hpp>

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
struct Motion {
  Eigen::Matrix3d linear;
  Eigen::Vector3d shift;

  Motion(const RigidTransform& pose, double source_scale, const Eigen::Vector3d& source_origin, const Cloud& target)
      : linear(target.scale() / source_scale * pose.linear()),
        shift(target.scale() * (pose * source_origin - vector_of(target.origin()))) {}

  [[nodiscard]] WorkingMotion rounded() const {
    WorkingMotion motion;
    const auto split = [](double value, float& first, float& rest) {
      first = static_cast<float>(value);
      rest = static_cast<float>(value - static_cast<double>(first));
    };
    for (Eigen::Index r = 0; r < 3; ++r) {
      split(shift[r], motion.shift[r], motion.shift_rest[r]);
      for (Eigen::Index c = 0; c < 3; ++c) {
        split(linear(r, c), motion.linear[3 * r + c], motion.linear_rest[3 * r + c]);
      }
    }
    return motion;
  }
};

}  // namespace

std::vector<std::uint32_t> rows_by_target_cell(const Cloud& source, const CellGrid& target,
                                               const RigidTransform& pose) {
  const Motion motion(pose, source.scale(), vector_of(source.origin()), target.cloud());
  constexpr double kMost = 0x1p20;
  std::vector<std::uint64_t> keys(source.size());
  const CloudView view = source.view();
  for (std::size_t row = 0; row < source.size(); ++row) {
    const Eigen::Vector3d p(static_cast<double>(view.points(0)[row]), static_cast<double>(view.points(1)[row]),
                            static_cast<double>(view.points(2)[row]));
    const Eigen::Vector3d x = motion.linear * p + motion.shift;
    for (std::size_t c = 3; c-- > 0;) {
      const double place = target.cells_along(c, static_cast<float>(x[static_cast<Eigen::Index>(c)]));
      keys[row] = keys[row] << 21U | static_cast<std::uint64_t>(place > 0.0 ? std::min(place, kMost) + 1.0 : 0.0);
    }
  }
  return sorting_order(keys);
}

ClosestPairs::ClosestPairs(const Cloud& source, std::span<const std::uint32_t> rows, const CellGrid& target,
                           double max_distance, double reach)
    : target_(target),
      size_(rows.size()),
      source_scale_(source.scale()),
      source_origin_(vector_of(source.origin())),
      max_distance_(static_cast<float>(max_distance * target.cloud().scale())),
      reach_(static_cast<float>(reach * target.cloud().scale())),
      blocks_((rows.size() + PairBlock::kSize - 1) / PairBlock::kSize) {
  const CloudView view = source.view();
  for (std::size_t i = 0; i < size_; ++i) {
    PairBlock& block = blocks_[i / PairBlock::kSize];
    const std::size_t k = i % PairBlock::kSize;
    for (std::size_t c = 0; c < 3; ++c) {
      block.from[c][k] = view.points(c)[rows[i]];
      block.normals[c][k] = view.has_normals() ? view.normals(c)[rows[i]] : 0.0f;
      block.looked[c][k] = std::numeric_limits<float>::quiet_NaN();
    }
    block.trust[k] = -1.0f;
    block.rows[k] = static_cast<std::uint32_t>(target.size());
  }
}

void ClosestPairs::search(CellWalk& walk, PairBlock& block, std::size_t entry, std::uint32_t guess) const {
  const CloudView target = target_.cloud().view();
  const std::array<float, 3> point{block.points[0][entry], block.points[1][entry], block.points[2][entry]};
  const float gone = distance(point, {block.looked[0][entry], block.looked[1][entry], block.looked[2][entry]});
  std::array<std::uint32_t, 2> nearest{};
  std::array<float, 2> squared{};
  const auto look = [&](float reach) {
    const double radius = static_cast<double>(reach) / target.scale();
    return nearest_within(target, point, walk.runs_within(point, radius), radius, nearest, squared);
  };
  // The nearest is no further away than the guess. As steps become shorter the point will go about as far as it has
  // come, and may go half of the distance between the nearest and the second one: a third is wanted on top.
  constexpr float kAhead = 1.5f;
  float reach = reach_;
  if (guess < target.size()) {
    const float ahead = gone >= 0.0f ? kAhead * gone : 0.0f;  // never looked for where it is NaN
    reach = std::min(reach_, distance(point, point_of(target, guess)) + ahead + 3.0f * kRounding);
  }
  std::size_t count = look(reach);
  if (count == 0 && reach < reach_) {
    reach = reach_;
    count = look(reach);
  }
  const float first = count > 0 ? std::sqrt(squared[0]) : reach;
  const float second = count > 1 ? std::sqrt(squared[1]) : reach;
  const float none = first - max_distance_ - kRounding;  // within this there is no pair
  block.rows[entry] = count > 0 ? nearest[0] : static_cast<std::uint32_t>(target.size());
  block.trust[entry] = count > 0 ? std::max(0.5f * (second - first) - kRounding, none) : none;
  for (std::size_t c = 0; c < 3; ++c) block.looked[c][entry] = point[c];
}

void ClosestPairs::move(const RigidTransform& T_target_source) {
  const WorkingMotion motion = Motion(T_target_source, source_scale_, source_origin_, target_.cloud()).rounded();
  const auto none = static_cast<std::uint32_t>(target_.size());
  tbb::parallel_for(std::size_t{0}, blocks(), [&](std::size_t b) {
    CellWalk walk(target_);
    PairBlock& block = blocks_[b];
    std::array<std::uint64_t, PairBlock::kSize / 64> stale;
    move_pairs(block, entries(b), motion, stale);
    std::uint32_t last = none;  // the nearest of the entry before, a neighbour
    for (std::size_t word = 0; word < stale.size(); ++word) {
      for (std::uint64_t bits = stale[word]; bits != 0; bits &= bits - 1) {
        const std::size_t entry = 64 * word + static_cast<std::size_t>(std::countr_zero(bits));
        search(walk, block, entry, block.rows[entry] < none ? block.rows[entry] : last);
        if (block.rows[entry] < none) last = block.rows[entry];
      }
    }
  });
}

}  // namespace consimd::features::detail
