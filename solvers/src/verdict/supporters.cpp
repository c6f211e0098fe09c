#include "verdict/supporters.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "support/cell_keys.hpp"
#include "support/points.hpp"
#include "support/row_blocks.hpp"

namespace consimd::detail {
namespace {

// Bit b of a row: it supports the pose at the tested bound b.
using BoundMask = std::uint8_t;
static_assert(kTestedBounds.size() <= 8);

// The points that count, in cells of more than twice the radius: what is within the radius of a point lies in the
// point's own cell or, along each axis, in the one that it is nearer to. Cells share the slots of a hash table, which
// costs comparisons and changes nothing, since points are compared by their distance.
class CountedPoints {
 public:
  // Lengths of the working frame.
  CountedPoints(std::size_t most, double radius)
      : limit_(radius * radius),
        cells_per_length_(1.0 / std::max(kCellRadii * radius, kLeastCell)),
        first_(std::bit_ceil(kSlotsPerPoint * most + 1), kNone) {
    points_.reserve(most);
  }

  // The bounds, of `bounds`, at which no counted point is within the radius of `p`: it counts there from now on.
  BoundMask count(const Point& p, BoundMask bounds) {
    const std::array<std::uint64_t, 8> cells = cells_about(p, cells_per_length_);
    BoundMask free = bounds;
    for (std::size_t c = 0; c < cells.size() && free != 0; ++c) {
      for (std::uint32_t k = first_[slot_of(cells[c], first_.size())]; k != kNone; k = points_[k].next) {
        if ((points_[k].bounds & free) != 0 && squared_distance(p, points_[k].point) < limit_) {
          free = static_cast<BoundMask>(free & ~points_[k].bounds);
        }
      }
    }
    if (free != 0) {
      std::uint32_t& first = first_[slot_of(cells.front(), first_.size())];
      points_.push_back({p, first, free});
      first = static_cast<std::uint32_t>(points_.size() - 1);
    }
    return free;
  }

 private:
  // A little more than two, for rounding.
  static constexpr double kCellRadii = 2.001;
  // The working frame is [-1, 1] across, two at most: its cells are fewer than fit in an integer of 64 bits.
  static constexpr double kLeastCell = 1e-8;
  static constexpr std::size_t kSlotsPerPoint = 2;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Counted {
    Point point;
    std::uint32_t next;
    BoundMask bounds;
  };

  double limit_;
  double cells_per_length_;
  std::vector<std::uint32_t> first_;
  std::vector<Counted> points_;
};

}  // namespace

Supports supports(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double radius,
                  std::span<const Eigen::Vector3f> along) {
  const auto place = [along](const Point& p) {
    Eigen::Vector3f result(p.x, p.y, p.z);
    for (const Eigen::Vector3f& direction : along) result -= direction.dot(result) * direction;
    return Point{result.x(), result.y(), result.z()};
  };
  std::vector<std::uint64_t> bits(kTestedBounds.size() * view.words());
  Supports result;
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    result[b].count = row_blocks::alignment_bits(view, pose, kTestedBounds[b] * noise_bound,
                                                 std::span(bits).subspan(b * view.words(), view.words()));
  }
  const double most = std::ranges::max(result, {}, &Support::count).count;
  CountedPoints counted(static_cast<std::size_t>(most), radius * view.scale());
  for (std::size_t word = 0; word < view.words(); ++word) {
    std::uint64_t any = 0;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) any |= bits[b * view.words() + word];
    for (; any != 0; any &= any - 1) {
      const auto bit = static_cast<unsigned>(std::countr_zero(any));
      BoundMask bounds = 0;
      for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
        bounds = static_cast<BoundMask>(bounds | ((bits[b * view.words() + word] >> bit & 1U) << b));
      }
      bounds = counted.count(place(source_point(view, word * kBlock + bit)), bounds);
      for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
        result[b].spread += static_cast<unsigned>(bounds) >> b & 1U;
      }
    }
  }
  return result;
}

}  // namespace consimd::detail
