#include "verdict/clustering.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "support/points.hpp"

namespace consimd::detail {
namespace {

constexpr std::size_t kBlockRows = 16;  // neighbours looked at together

using Rows = std::span<std::uint32_t>;

std::size_t widest_axis(const CorrespondenceView& view, Rows rows) {
  std::size_t widest = 0;
  float largest = -1.0F;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* x = view.source(axis);
    const auto [low, high] = std::ranges::minmax(rows, {}, [x](std::uint32_t row) { return x[row]; });
    if (x[high] - x[low] > largest) {
      largest = x[high] - x[low];
      widest = axis;
    }
  }
  return widest;
}

// Halves the rows at the median of the sources' wider axis until blocks of neighbours are left.
void split(const CorrespondenceView& view, Rows rows, std::vector<Rows>& blocks) {
  if (rows.size() <= kBlockRows) {
    blocks.push_back(rows);
    return;
  }
  const float* x = view.source(widest_axis(view, rows));
  const std::size_t half = rows.size() / 2;
  // Equal coordinates in the order of rows: what a block holds is the same on every platform.
  std::ranges::nth_element(rows, rows.begin() + static_cast<std::ptrdiff_t>(half),
                           [x](std::uint32_t a, std::uint32_t b) { return x[a] < x[b] || (x[a] == x[b] && a < b); });
  split(view, rows.first(half), blocks);
  split(view, rows.subspan(half), blocks);
}

float squared_diameter(const CorrespondenceView& view, Rows rows) {
  float largest = 0.0F;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const Point p = source_point(view, rows[a]);
    for (const std::uint32_t b : rows.first(a)) largest = std::max(largest, squared_distance(p, source_point(view, b)));
  }
  return largest;
}

// Number of pairs, one row from each block, whose targets are closer than a bound; a row is no pair with itself.
double close_targets(const CorrespondenceView& view, Rows block, Rows other, float squared_bound) {
  std::size_t close = 0;
  for (const std::uint32_t i : block) {
    const Point p = target_point(view, i);
    for (const std::uint32_t j : other) {
      close += i != j && squared_distance(p, target_point(view, j)) < squared_bound ? 1U : 0U;
    }
  }
  return static_cast<double>(close);
}

}  // namespace

double clustered_share(const CorrespondenceView& view) {
  std::vector<std::uint32_t> rows(view.size());
  std::iota(rows.begin(), rows.end(), 0U);
  std::vector<Rows> blocks;
  split(view, rows, blocks);
  double near = 0.0;
  double near_trials = 0.0;
  double far = 0.0;
  double far_trials = 0.0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const Rows block = blocks[b];
    const Rows other = blocks[(b + blocks.size() / 2) % blocks.size()];
    const float squared_bound = squared_diameter(view, block);
    near += close_targets(view, block, block, squared_bound);
    near_trials += static_cast<double>(block.size() * (block.size() - 1));
    if (blocks.size() == 1) break;
    far += close_targets(view, block, other, squared_bound);
    far_trials += static_cast<double>(block.size() * other.size());
  }
  if (near_trials == 0.0 || far_trials == 0.0 || far == far_trials) return 0.0;
  return (near / near_trials - far / far_trials) / (1.0 - far / far_trials);
}

}  // namespace consimd::detail
