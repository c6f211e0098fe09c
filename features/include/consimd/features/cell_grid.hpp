// A cloud sorted into cells, in which the neighbours of a point are found.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// Owner of a copy of a cloud whose points are sorted by cubic cells, x ascending fastest, then y, then z; within a
/// cell they keep their order. All radii that are asked for later are at most the side of a cell: the neighbours of a
/// point then lie in the 27 cells around it, which are nine runs of points.
class CellGrid {
 public:
  /// cell: side of a cell in the caller's unit. Throws std::invalid_argument unless it is finite and > 0, or where the
  /// cloud is more than 2^20 cells long.
  CellGrid(const Cloud& cloud, double cell);

  /// The points in their new order. Rows are of this cloud from here on.
  [[nodiscard]] const Cloud& cloud() const noexcept { return cloud_; }
  [[nodiscard]] std::size_t size() const noexcept { return cloud_.size(); }
  [[nodiscard]] double cell() const noexcept { return cell_; }
  /// Which point of the original cloud a row is. row < size().
  [[nodiscard]] std::uint32_t original(std::size_t row) const noexcept { return order_[row]; }

  /// Gives the points normals, as Cloud::set_normals.
  void set_normals(const std::array<const float*, 3>& normals) { cloud_.set_normals(normals); }

  // What a search walks through: occupied cells, ascending by key.
  [[nodiscard]] std::size_t cells() const noexcept { return keys_.size(); }
  [[nodiscard]] std::uint64_t key(std::size_t cell) const noexcept { return keys_[cell]; }
  /// First row of a cell, and the number of rows at cells().
  [[nodiscard]] std::uint32_t first(std::size_t cell) const noexcept { return firsts_[cell]; }
  /// The first cell whose key is not below `key`, cells() where there is none.
  [[nodiscard]] std::size_t first_not_below(std::uint64_t key) const noexcept {
    const std::uint64_t bucket = key >> bucket_bits_;
    if (bucket + 1 >= buckets_.size()) return keys_.size();
    std::size_t low = buckets_[bucket];
    std::size_t high = buckets_[bucket + 1];
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (keys_[middle] < key) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }
  /// What is added to a key to come to the next cell along an axis.
  [[nodiscard]] const std::array<std::uint64_t, 3>& strides() const noexcept { return strides_; }
  /// How many cells a coordinate of the working frame lies beyond the lowest one of the cloud; the key of a place
  /// within the cloud is the sum of the strides times the whole cells and one.
  [[nodiscard]] double cells_along(std::size_t axis, float coordinate) const noexcept {
    return (static_cast<double>(coordinate) - low_[axis]) * per_length_;
  }

 private:
  double cell_;
  Cloud cloud_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> firsts_;
  // Entry b: the first cell whose key is not below b << bucket_bits_; the last one is the number of cells.
  std::vector<std::uint32_t> buckets_;
  unsigned bucket_bits_ = 0;
  std::array<std::uint64_t, 3> strides_{};
  std::array<double, 3> low_{};
  double per_length_ = 0.0;
};

/// Neighbours of some points: those of rows[k] are entries starts[k] to starts[k + 1] - 1.
struct NeighbourLists {
  std::vector<std::size_t> starts;
  std::vector<std::uint32_t> rows;
  std::vector<double> distances;  ///< caller's unit
};

/// The points within `radius` (caller's unit, at most the grid's cell) of each of `rows`, themselves among them,
/// ascending by row. rows: of grid.cloud(), ascending. Throws std::invalid_argument on a bad radius or rows that do not
/// ascend, std::out_of_range on a bad row.
[[nodiscard]] NeighbourLists radius_neighbours(const CellGrid& grid, std::span<const std::uint32_t> rows,
                                               double radius);

/// The nearest points of a cloud to each of some queries, `most` entries a query: ascending by distance, equally near
/// ones by row; where fewer are within the radius the rest are kNone and infinity.
struct NearestLists {
  static constexpr std::uint32_t kNone = 0xffffffff;
  std::size_t most = 0;
  std::vector<std::uint32_t> rows;  ///< of grid.cloud()
  std::vector<double> distances;    ///< caller's unit
};

/// The at most `most` nearest points within `radius` (caller's unit, at most the grid's cell) of each of `queries`,
/// which need not be points of the cloud; caller's frame. A query that is not finite has none. In parallel. Throws
/// std::invalid_argument on a bad radius or unless `most` is between 1 and 64.
[[nodiscard]] NearestLists nearest_neighbours(const CellGrid& grid, std::span<const std::array<double, 3>> queries,
                                              std::size_t most, double radius);

/// Distance from a point to its nearest neighbour, the median over up to 2000 points evenly spread over the rows, in
/// the caller's unit: the paper's resolution of a cloud. Infinite where half of them or more have no neighbour within a
/// cell. Throws std::invalid_argument on an empty cloud.
[[nodiscard]] double resolution(const CellGrid& grid);

}  // namespace features
}  // namespace consimd
