#include "grid/neighbourhoods.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace consimd::features::detail {

CellWalk::CellWalk(const CellGrid& grid)
    : grid_(grid), cell_per_length_(grid.cells_along(0, 1.0f) - grid.cells_along(0, 0.0f)) {
  // The first layer of empty cells behind the cloud's; along the last axis keys beyond it meet no cell.
  const auto& strides = grid.strides();
  const std::uint64_t rows = strides[2] / strides[1];
  furthest_ = {static_cast<double>(strides[1]) - 2.0, static_cast<double>(rows) - 2.0, 0x1p20};
}

std::size_t CellWalk::end_of_run(std::size_t begin, std::uint64_t key) const {
  while (begin < grid_.cells() && grid_.key(begin) < key) ++begin;
  return begin;
}

std::span<const PointRun> CellWalk::runs_around(std::size_t cell) {
  const auto& strides = grid_.strides();
  const std::uint64_t centre = grid_.key(cell);
  std::size_t count = 0;
  points_ = 0;
  for (std::size_t row = 0; row < 9; ++row) {
    // The layers of empty cells around the cloud keep these above 0 and within their rows.
    const std::uint64_t first = centre + (row % 3) * strides[1] + (row / 3) * strides[2] - strides[1] - strides[2] - 1;
    const std::size_t begin = grid_.first_not_below(first);
    const PointRun run{grid_.first(begin), grid_.first(end_of_run(begin, first + 3))};
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

std::span<const PointRun> CellWalk::runs_within(const std::array<float, 3>& point, double radius) {
  // A little more than asked for, so that rounding leaves out no point at the very radius.
  const double reach = (1.0 + 1e-5) * radius * grid_.cloud().scale() * cell_per_length_;
  std::array<std::int64_t, 3> low{}, high{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double place = grid_.cells_along(c, point[c]);
    if (!(place >= -1.0 && place <= furthest_[c] + 1.0)) return {};
    // Cells from 1 on, as keys count them: beyond the layers of empty cells there is nothing.
    low[c] = static_cast<std::int64_t>(std::max(place - reach, 0.0)) + 1;
    high[c] = static_cast<std::int64_t>(std::max(std::min(place + reach, furthest_[c]), -1.0) + 1.0);
  }
  if (high[0] < low[0]) return {};
  const auto stride = [&](std::size_t c) { return static_cast<std::int64_t>(grid_.strides()[c]); };
  std::size_t count = 0;
  for (std::int64_t z = low[2]; z <= high[2]; ++z) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      const std::int64_t base = z * stride(2) + y * stride(1);
      const std::size_t begin = grid_.first_not_below(static_cast<std::uint64_t>(base + low[0]));
      const std::size_t end = end_of_run(begin, static_cast<std::uint64_t>(base + high[0] + 1));
      if (end == begin || count == runs_.size()) continue;
      runs_[count++] = {grid_.first(begin), grid_.first(end)};
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
