#include "clustering.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "points.hpp"

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

double diameter(const CorrespondenceView& view, Rows rows) {
  double largest = 0.0;
  for (const std::uint32_t i : rows) {
    for (const std::uint32_t j : rows) {
      largest = std::max(largest, distance(source_point(view, i), source_point(view, j)));
    }
  }
  return largest;
}

// Number of pairs, one row from each block, whose targets are within `bound`; a row is no pair with itself.
double close_targets(const CorrespondenceView& view, Rows block, Rows other, double bound) {
  double close = 0.0;
  for (const std::uint32_t i : block) {
    for (const std::uint32_t j : other) {
      close += i != j && distance(target_point(view, i), target_point(view, j)) < bound ? 1.0 : 0.0;
    }
  }
  return close;
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
    const double bound = diameter(view, block);
    near += close_targets(view, block, block, bound);
    near_trials += static_cast<double>(block.size() * (block.size() - 1));
    if (blocks.size() == 1) break;
    far += close_targets(view, block, other, bound);
    far_trials += static_cast<double>(block.size() * other.size());
  }
  if (near_trials == 0.0 || far_trials == 0.0 || far == far_trials) return 0.0;
  return (near / near_trials - far / far_trials) / (1.0 - far / far_trials);
}

}  // namespace consimd::detail
