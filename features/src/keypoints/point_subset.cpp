#include <consimd/features/point_subset.hpp>

#include <Random123/philox.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "grid/box.hpp"
#include "grid/cell_keys.hpp"

namespace consimd::features {
namespace {

using Place = std::array<float, 3>;

/// The rows along a curve that keeps neighbours together (Morton 1966): ten bits of each coordinate, interleaved.
std::vector<std::uint32_t> along_curve(const Cloud& cloud) {
  const detail::Box box = detail::box_around(cloud);
  const CloudView view = cloud.view();
  std::vector<std::uint64_t> keys(cloud.size());
  for (std::size_t c = 0; c < 3; ++c) {
    const float length = box.high[c] - box.low[c];
    const float per_length = length > 0.0f ? 1023.0f / length : 0.0f;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      // At most 1024 for rounding, whose bit 10 the next lines take as well.
      auto place = static_cast<std::uint64_t>((view.points(c)[i] - box.low[c]) * per_length);
      for (std::size_t bit = c; place != 0; place >>= 1U, bit += 3) keys[i] |= (place & 1U) << bit;
    }
  }
  return detail::sorting_order(keys);
}

/// A cloud in parts of neighbours. A part whose box is further from a chosen point than any of its points is from the
/// points chosen before needs no look: the distance to the box is rounded as those to its points are, so that it never
/// is above one of them.
class FarthestSearch {
 public:
  explicit FarthestSearch(const Cloud& cloud) : rows_(along_curve(cloud)), points_(rows_.size()) {
    const CloudView view = cloud.view();
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      points_[k] = {view.points(0)[rows_[k]], view.points(1)[rows_[k]], view.points(2)[rows_[k]]};
    }
    nearest_.assign(rows_.size(), std::numeric_limits<float>::infinity());
    for (std::size_t begin = 0; begin < rows_.size(); begin += kPart) {
      Part part{points_[begin], points_[begin], nearest_[begin], rows_[begin], begin};
      for (std::size_t k = begin; k < std::min(rows_.size(), begin + kPart); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          part.low[c] = std::min(part.low[c], points_[k][c]);
          part.high[c] = std::max(part.high[c], points_[k][c]);
        }
      }
      parts_.push_back(part);
    }
  }

  /// Takes entry k; returns its row.
  std::uint32_t choose(std::size_t k) {
    const Place chosen = points_[k];
    nearest_[k] = kChosen;
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      Part& part = parts_[p];
      if (k / kPart == p || squared_distance(part, chosen) < part.distance) update(p, chosen);
    }
    return rows_[k];
  }

  /// The entry that is furthest from those taken.
  [[nodiscard]] std::size_t farthest() const {
    const Part* best = parts_.data();
    for (const Part& part : parts_) {
      if (part.distance > best->distance || (part.distance == best->distance && part.row < best->row)) best = &part;
    }
    return best->farthest;
  }

  [[nodiscard]] std::size_t entry_of(std::uint32_t row) const {
    return static_cast<std::size_t>(std::find(rows_.begin(), rows_.end(), row) - rows_.begin());
  }

 private:
  static constexpr std::size_t kPart = 64;
  static constexpr float kChosen = -1.0f;  // below all squared distances

  struct Part {
    Place low;
    Place high;
    // Of the point that is furthest from those taken:
    float distance;
    std::uint32_t row;
    std::size_t farthest;  // its entry
  };

  static float squared_distance(const Part& part, const Place& to) {
    float squared = 0.0f;
    for (std::size_t c = 0; c < 3; ++c) {
      const float beyond = std::max({part.low[c] - to[c], to[c] - part.high[c], 0.0f});
      squared += beyond * beyond;
    }
    return squared;
  }

  [[nodiscard]] bool is_farther(std::size_t k, std::size_t than) const {
    return nearest_[k] > nearest_[than] || (nearest_[k] == nearest_[than] && rows_[k] < rows_[than]);
  }

  void update(std::size_t p, const Place& chosen) {
    const std::size_t begin = p * kPart;
    const std::size_t end = std::min(rows_.size(), begin + kPart);
    std::size_t farthest = begin;
    for (std::size_t k = begin; k < end; ++k) {
      float squared = 0.0f;
      for (std::size_t c = 0; c < 3; ++c) squared += (points_[k][c] - chosen[c]) * (points_[k][c] - chosen[c]);
      nearest_[k] = std::min(nearest_[k], squared);
      if (is_farther(k, farthest)) farthest = k;
    }
    Part& part = parts_[p];
    part.distance = nearest_[farthest];
    part.row = rows_[farthest];
    part.farthest = farthest;
  }

  std::vector<std::uint32_t> rows_;
  std::vector<Place> points_;
  std::vector<float> nearest_;  // squared, working frame
  std::vector<Part> parts_;
};

}  // namespace

std::vector<std::uint32_t> random_subset(std::size_t size, std::size_t count, std::uint64_t seed) {
  std::vector<std::uint32_t> rows(std::min(size, count));
  if (count >= size) {
    std::iota(rows.begin(), rows.end(), 0u);
    return rows;
  }
  // Selection sampling (Knuth, The Art of Computer Programming, vol. 2, algorithm S): a row is taken with the share of
  // those still wanted among those still to come.
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  constexpr std::uint32_t kStream = 100;  // none of the solvers'
  std::size_t taken = 0;
  for (std::size_t row = 0; taken < rows.size(); ++row) {
    const auto draws = r123::Philox4x32()({{0, kStream, static_cast<std::uint32_t>(row), 0}}, key);
    const std::uint64_t left = size - row;
    if (std::uint64_t{draws[0]} * left >> 32 < rows.size() - taken) rows[taken++] = static_cast<std::uint32_t>(row);
  }
  return rows;
}

std::vector<std::uint32_t> farthest_subset(const Cloud& cloud, std::size_t count, std::uint64_t seed) {
  count = std::min(count, cloud.size());
  if (count == 0) return {};
  FarthestSearch search(cloud);
  std::vector<std::uint32_t> rows{search.choose(search.entry_of(random_subset(cloud.size(), 1, seed).front()))};
  rows.reserve(count);
  while (rows.size() < count) rows.push_back(search.choose(search.farthest()));
  return rows;
}

}  // namespace consimd::features
