#include "grid/neighbourhoods.hpp"

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace consimd::features::detail {
namespace {

/// The first cell at or behind `from` whose key is not below `key`: near `from` as a rule.
std::size_t first_not_below(const CellGrid& grid, std::size_t from, std::uint64_t key) {
  std::size_t low = from;
  std::size_t high = from;
  for (std::size_t step = 1; high < grid.cells() && grid.key(high) < key; step *= 2) {
    low = high + 1;
    high = std::min(grid.cells(), high + step);
  }
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (grid.key(middle) < key) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

}  // namespace

std::span<const PointRun> CellWalk::runs_around(std::size_t cell) {
  const auto& strides = grid_.strides();
  const std::uint64_t centre = grid_.key(cell);
  std::size_t count = 0;
  points_ = 0;
  for (std::size_t row = 0; row < 9; ++row) {
    // The layers of empty cells around the cloud keep these above 0 and within their rows.
    const std::uint64_t first = centre + (row % 3) * strides[1] + (row / 3) * strides[2] - strides[1] - strides[2] - 1;
    begins_[row] = first_not_below(grid_, begins_[row], first);
    ends_[row] = first_not_below(grid_, std::max(begins_[row], ends_[row]), first + 3);
    const PointRun run{grid_.first(begins_[row]), grid_.first(ends_[row])};
    if (run.first == run.last) continue;
    points_ += run.last - run.first;
    if (count > 0 && runs_[count - 1].last == run.first) {
      runs_[count - 1].last = run.last;
    } else {
      runs_[count++] = run;
    }
  }
  return std::span(runs_).first(count);
}

void require_radius(const CellGrid& grid, double radius, const char* name) {
  if (std::isfinite(radius) && radius > 0.0 && radius <= grid.cell()) return;
  throw std::invalid_argument(std::string(name) + " is " + std::to_string(radius) +
                              ", expected a length above 0, at most the side of a cell, " +
                              std::to_string(grid.cell()));
}

void require_ascending(std::span<const std::uint32_t> rows, std::size_t size) {
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (rows[k] >= size) {
      throw std::out_of_range("point " + std::to_string(rows[k]) + " of " + std::to_string(size));
    }
    if (k > 0 && rows[k] <= rows[k - 1]) {
      throw std::invalid_argument("rows[" + std::to_string(k) + "] is " + std::to_string(rows[k]) + " after " +
                                  std::to_string(rows[k - 1]) + ", expected ascending rows");
    }
  }
}

std::vector<std::uint32_t> all_rows(std::size_t size) {
  std::vector<std::uint32_t> rows(size);
  std::iota(rows.begin(), rows.end(), 0u);
  return rows;
}

}  // namespace consimd::features::detail
