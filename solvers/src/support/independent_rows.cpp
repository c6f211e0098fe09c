#include "support/independent_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <unordered_map>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

// What is matched cluster to cluster moves as one over about so many noise bounds: beyond, rows are independent.
constexpr double kIndependent = 3.0;
// Without a tenth of dependent rows, a search among the others would be the one that was.
constexpr double kFewDependent = 0.9;

// Rows a place from which on places recur, and how many places are few: neighbours on a dense surface are close to one
// another as well, but in many places. Among as many rows as the product few places recur. So many of them are looked
// at to tell.
constexpr std::size_t kRecurring = 3;
constexpr std::size_t kFewPlaces = 64;
constexpr std::size_t kLookedAt = 8;

using Cell = std::array<std::int64_t, 3>;

// Of so many rows a look at each takes as long as finding those of 27 cells.
constexpr std::size_t kManyInACell = 256;

// The rows kept, by the cells, as long as the radius, of their sources and, where a source's cell has many, of their
// targets too: of a source that is matched with everything each row would be held against all others. Far cells may
// share a key, which costs time only.
class KeptRows {
 public:
  KeptRows(const CorrespondenceView& view, float radius)
      : view_(view), limit_(radius * radius), per_length_(1.0F / radius) {}

  /// Whether a kept row is within the radius in both clouds.
  [[nodiscard]] bool repeats(const Point& p, const Point& q) const {
    return std::ranges::any_of(keys_about(cell(p)), [&](std::uint64_t of_source) {
      const auto found = by_source_.find(of_source);
      return found != by_source_.end() && repeats(found->second, p, q);
    });
  }

  void add(std::uint32_t row, const Point& p, const Point& q) {
    Sharing& sharing = by_source_[key(cell(p))];
    sharing.rows.push_back(row);
    if (sharing.rows.size() <= kManyInACell) return;
    if (sharing.by_target.empty()) {
      for (const std::uint32_t other : sharing.rows) {
        sharing.by_target[key(cell(target_point(view_, other)))].push_back(other);
      }
    } else {
      sharing.by_target[key(cell(q))].push_back(row);
    }
  }

 private:
  // Rows whose sources share a cell.
  struct Sharing {
    std::vector<std::uint32_t> rows;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> by_target;  // once they are many
  };

  [[nodiscard]] bool repeats(const Sharing& sharing, const Point& p, const Point& q) const {
    const auto any_close = [&](const std::vector<std::uint32_t>& rows) {
      return std::ranges::any_of(rows, [&](std::uint32_t other) {
        return squared_distance(p, source_point(view_, other)) < limit_ &&
               squared_distance(q, target_point(view_, other)) < limit_;
      });
    };
    if (sharing.by_target.empty()) return any_close(sharing.rows);
    return std::ranges::any_of(keys_about(cell(q)), [&](std::uint64_t of_target) {
      const auto found = sharing.by_target.find(of_target);
      return found != sharing.by_target.end() && any_close(found->second);
    });
  }

  static constexpr std::size_t kNeighbours = 27;

  [[nodiscard]] Cell cell(const Point& p) const { return {index(p.x), index(p.y), index(p.z)}; }
  [[nodiscard]] std::int64_t index(float x) const { return static_cast<std::int64_t>(std::floor(x * per_length_)); }

  [[nodiscard]] static std::uint64_t key(const Cell& cell) {
    constexpr std::uint64_t kMask = (1U << 21U) - 1U;
    const auto part = [](std::int64_t index) { return static_cast<std::uint64_t>(index) & kMask; };
    return part(cell[0]) | (part(cell[1]) << 21U) | (part(cell[2]) << 42U);
  }

  // The keys of a cell and of those beside it.
  [[nodiscard]] static std::array<std::uint64_t, kNeighbours> keys_about(const Cell& cell) {
    std::array<std::uint64_t, kNeighbours> keys{};
    for (int n = 0; n < static_cast<int>(kNeighbours); ++n) {
      keys[static_cast<std::size_t>(n)] = key({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
    }
    return keys;
  }

  CorrespondenceView view_;
  float limit_;
  float per_length_;
  std::unordered_map<std::uint64_t, Sharing> by_source_;
};

}  // namespace

std::vector<std::uint32_t> independent_rows(const CorrespondenceView& view, double radius) {
  // Points of the working frame lie in [-1, 1] or not far from it.
  KeptRows kept(view, static_cast<float>(std::max(radius * view.scale(), 1e-6)));
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    // One of NaN is a far row.
    if (std::isnan(p.x) || kept.repeats(p, q)) continue;
    kept.add(row, p, q);
    rows.push_back(row);
  }
  return rows;
}

bool are_of_few_places(const CorrespondenceView& view, const std::vector<std::uint32_t>& rows, double noise_bound) {
  const auto reach = static_cast<float>(noise_bound * view.scale());
  const std::size_t count = std::min(rows.size(), kRecurring * kFewPlaces);
  const std::size_t looked_at = std::min(count, kLookedAt);
  const auto row_at = [&](std::size_t k, std::size_t of) { return rows[k * rows.size() / of]; };
  // Of as many rows at one place each is that part of a place.
  double places = 0.0;
  for (std::size_t k = 0; k < looked_at; ++k) {
    const std::uint32_t row = row_at(k * count / looked_at, count);
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    std::size_t there = 0;
    for (std::size_t j = 0; j < count; ++j) {
      const std::uint32_t other = row_at(j, count);
      if (squared_distance(p, source_point(view, other)) <= reach * reach &&
          squared_distance(q, target_point(view, other)) <= reach * reach) {
        ++there;
      }
    }
    places += 1.0 / static_cast<double>(there);
  }
  return looked_at > 0 && static_cast<double>(kRecurring) * places <= static_cast<double>(looked_at);
}

std::vector<std::uint32_t> rows_for_another_search(const CorrespondenceView& view, double noise_bound) {
  std::vector<std::uint32_t> rows = independent_rows(view, kIndependent * noise_bound);
  const bool as_before = static_cast<double>(rows.size()) > kFewDependent * static_cast<double>(view.size());
  if (rows.size() < 3 || as_before) rows.clear();
  return rows;
}

}  // namespace consimd::detail
