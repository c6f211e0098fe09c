// The points of a cloud by place, to find those near another.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "support/cell_keys.hpp"
#include "support/points.hpp"

namespace consimd::detail {

/// Points in cells of more than twice a radius, slot by slot of a hash table. Working frame.
class PointCells {
 public:
  /// `point_of`: of a row below `size`. Far rows, which are not a number, are left out.
  template <typename PointOf>
  PointCells(std::size_t size, double radius, const PointOf& point_of)
      : cells_per_length_(1.0 / std::max(kCellRadii * radius, kLeastCell)), first_(std::bit_ceil(size) + 1) {
    std::vector<Entry> entries;
    entries.reserve(size);
    for (std::uint32_t row = 0; row < size; ++row) {
      const Point p = point_of(row);
      if (!std::isnan(p.x)) entries.push_back({cells_about(p, cells_per_length_).front(), p, row});
    }
    for (const Entry& entry : entries) ++first_[slot(entry.cell) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    entries_.resize(entries.size());
    for (const Entry& entry : entries) entries_[next[slot(entry.cell)]++] = entry;
  }

  /// visit(row, squared distance) of the points whose squared distance from p is below `limit`, the square of the
  /// radius or less.
  template <typename Visit>
  void visit(const Point& p, float limit, const Visit& visit) const {
    for (const std::uint64_t cell : cells_about(p, cells_per_length_)) {
      const std::size_t at = slot(cell);
      for (std::uint32_t k = first_[at]; k < first_[at + 1]; ++k) {
        const Entry& entry = entries_[k];
        const float squared = squared_distance(p, entry.point);
        if (squared < limit && entry.cell == cell) visit(entry.row, squared);
      }
    }
  }

 private:
  // A little more than two, for rounding.
  static constexpr double kCellRadii = 2.001;
  // The working frame is [-1, 1] across: a lattice as fine as this is counted by integers of 64 bits.
  static constexpr double kLeastCell = 1e-8;

  struct Entry {
    std::uint64_t cell;
    Point point;
    std::uint32_t row;
  };

  [[nodiscard]] std::size_t slot(std::uint64_t cell) const { return slot_of(cell, first_.size() - 1); }

  double cells_per_length_;
  std::vector<std::uint32_t> first_;  // of a slot, in entries_; one more: the end
  std::vector<Entry> entries_;
};

}  // namespace consimd::detail
