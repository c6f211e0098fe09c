#include "support/independent_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

// What is matched cluster to cluster moves as one over about so many noise bounds: beyond, rows are independent.
constexpr double kIndependent = 3.0;
// Without a tenth of dependent rows, a search among the others would be the one that was.
constexpr double kFewDependent = 0.9;

// Cells of the sources, as long as the radius. Far cells may share a key, which costs time only.
class Cells {
 public:
  explicit Cells(float edge) : per_length_(1.0F / edge) {}

  [[nodiscard]] std::array<std::int64_t, 3> cell(const Point& p) const { return {index(p.x), index(p.y), index(p.z)}; }
  [[nodiscard]] static std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::uint64_t kMask = (1U << 21U) - 1U;
    return (static_cast<std::uint64_t>(x) & kMask) | ((static_cast<std::uint64_t>(y) & kMask) << 21U) |
           ((static_cast<std::uint64_t>(z) & kMask) << 42U);
  }

 private:
  [[nodiscard]] std::int64_t index(float x) const { return static_cast<std::int64_t>(std::floor(x * per_length_)); }

  float per_length_;
};

}  // namespace

std::vector<std::uint32_t> independent_rows(const CorrespondenceView& view, double radius) {
  // Points of the working frame lie in [-1, 1] or not far from it.
  const auto reach = static_cast<float>(std::max(radius * view.scale(), 1e-6));
  const float limit = reach * reach;
  const Cells cells(reach);
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> kept;
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    if (std::isnan(p.x)) continue;  // a far row
    const auto [x, y, z] = cells.cell(p);
    bool repeats = false;
    for (int neighbour = 0; neighbour < 27 && !repeats; ++neighbour) {
      const auto found = kept.find(Cells::key(x + neighbour % 3 - 1, y + neighbour / 3 % 3 - 1, z + neighbour / 9 - 1));
      if (found == kept.end()) continue;
      repeats = std::ranges::any_of(found->second, [&](std::uint32_t other) {
        return squared_distance(p, source_point(view, other)) < limit &&
               squared_distance(q, target_point(view, other)) < limit;
      });
    }
    if (repeats) continue;
    kept[Cells::key(x, y, z)].push_back(row);
    rows.push_back(row);
  }
  return rows;
}

std::vector<std::uint32_t> rows_for_another_search(const CorrespondenceView& view, double noise_bound) {
  std::vector<std::uint32_t> rows = independent_rows(view, kIndependent * noise_bound);
  const bool as_before = static_cast<double>(rows.size()) > kFewDependent * static_cast<double>(view.size());
  if (rows.size() < 3 || as_before) rows.clear();
  return rows;
}

}  // namespace consimd::detail
