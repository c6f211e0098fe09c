#include "support/repeated_points.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

constexpr double kManyRows = 6.0;
constexpr std::size_t kLookedAt = 64;
constexpr std::size_t kLeastEqual = 3;

bool equal(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

std::tuple<float, float, float> key(const Point& p) { return {p.x, p.y, p.z}; }

// The points of the members in order, to look others up.
template <typename PointOf>
std::vector<std::tuple<float, float, float>> sorted_keys(std::span<const std::uint32_t> members,
                                                         const PointOf& point_of) {
  std::vector<std::tuple<float, float, float>> keys;
  keys.reserve(members.size());
  for (const std::uint32_t row : members) keys.push_back(key(point_of(row)));
  std::ranges::sort(keys);
  return keys;
}

}  // namespace

bool many_to_many(const CorrespondenceView& view) {
  const std::size_t size = view.size();
  const std::size_t looked_at = std::min(size, kLookedAt);
  // Rows spread by the golden ratio, which meets no period of the input.
  const auto row = [&](std::uint64_t k) {
    return static_cast<std::size_t>(((k * 0x9E3779B97F4A7C15U) >> 32U) * size >> 32U);
  };
  std::size_t equal_sources = 0;
  std::size_t equal_targets = 0;
  for (std::size_t a = 0; a < looked_at; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (row(a) == row(b)) continue;
      equal_sources += equal(source_point(view, row(a)), source_point(view, row(b))) ? 1U : 0U;
      equal_targets += equal(target_point(view, row(a)), target_point(view, row(b))) ? 1U : 0U;
    }
  }
  const double pairs = 0.5 * static_cast<double>(looked_at) * (static_cast<double>(looked_at) - 1.0);
  const std::size_t equal_pairs = std::min(equal_sources, equal_targets);
  return equal_pairs >= kLeastEqual &&
         1.0 + static_cast<double>(equal_pairs) * static_cast<double>(size) / pairs >= kManyRows;
}

std::vector<std::uint32_t> rows_sharing_a_point(const CorrespondenceView& view,
                                                std::span<const std::uint32_t> members) {
  const auto sources = sorted_keys(members, [&](std::uint32_t row) { return source_point(view, row); });
  const auto targets = sorted_keys(members, [&](std::uint32_t row) { return target_point(view, row); });
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    if (std::ranges::binary_search(members, row)) continue;
    if (std::ranges::binary_search(sources, key(source_point(view, row))) ||
        std::ranges::binary_search(targets, key(target_point(view, row)))) {
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace consimd::detail
