// The one search for neighbours that normals, descriptors and resolutions are made with.
#pragma once

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/neighbourhoods.hpp>

namespace consimd::features::detail {

/// The runs of points around one place after another.
class CellWalk {
 public:
  explicit CellWalk(const CellGrid& grid);

  /// The points of the 27 cells around an occupied one; valid until the next call. Runs that meet are joined.
  std::span<const PointRun> runs_around(std::size_t cell);

  /// The points of the cells that are within a radius, at most a cell, of any point of the working frame; valid until
  /// the next call of this function.
  std::span<const PointRun> runs_within(const std::array<float, 3>& point, double radius);

  /// How many points the last runs around a cell hold.
  [[nodiscard]] std::size_t points() const noexcept { return points_; }

 private:
  /// The first cell from `begin` on whose key is not below `key`, one of the next few.
  [[nodiscard]] std::size_t end_of_run(std::size_t begin, std::uint64_t key) const;

  const CellGrid& grid_;
  double cell_per_length_;            // of the working frame
  std::array<double, 3> furthest_{};  // cells along each axis that can be next to one of the cloud's
  std::array<PointRun, 9> runs_{};
  std::size_t points_ = 0;
};

/// Throws std::invalid_argument unless the radius is finite, > 0 and at most the grid's cell.
void require_radius(const CellGrid& grid, double radius, const char* name);

/// Throws std::invalid_argument unless the rows ascend, std::out_of_range on a bad one.
void require_ascending(std::span<const std::uint32_t> rows, std::size_t size);

/// 0, 1, ..., size - 1.
[[nodiscard]] std::vector<std::uint32_t> all_rows(std::size_t size);

/// What a search hands on: valid during the call.
struct Neighbourhood {
  std::uint32_t row;
  std::array<float, 3> point;                ///< working frame
  std::span<const std::uint32_t> rows;       ///< ascending, `row` among them
  std::span<const float> squared_distances;  ///< working frame
};

/// Calls work(begin, end, search) for parts of `rows` in parallel; search(k) gives the Neighbourhood of rows[k] and
/// wants ascending k. rows: ascending, valid; radius as `require_radius` has it.
template <typename Work>
void search_in_parts(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius, const Work& work) {
  constexpr std::size_t kPart = 256;
  const CloudView cloud = grid.cloud().view();
  const auto part = [&](std::size_t begin, std::size_t end) {
    CellWalk walk(grid);
    std::vector<std::uint32_t> indices;
    std::vector<float> squared;
    std::span<const PointRun> runs;
    std::size_t cell = 0;
    std::uint32_t cell_end = 0;
    const auto search = [&](std::size_t k) {
      const std::uint32_t row = rows[k];
      if (row >= cell_end) {
        // The cell of the row: at or behind the last one.
        std::size_t step = 1;
        std::size_t high = cell + 1;
        while (high < grid.cells() && grid.first(high) <= row) {
          cell = high;
          high = std::min(grid.cells(), high + step);
          step *= 2;
        }
        while (high - cell > 1) {
          const std::size_t middle = cell + (high - cell) / 2;
          (grid.first(middle) <= row ? cell : high) = middle;
        }
        cell_end = grid.first(cell + 1);
        runs = walk.runs_around(cell);
        if (indices.size() < walk.points() + kNeighbourSlack) {
          indices.resize(2 * walk.points() + kNeighbourSlack);
          squared.resize(indices.size());
        }
      }
      const std::array<float, 3> point{cloud.points(0)[row], cloud.points(1)[row], cloud.points(2)[row]};
      const std::size_t count = neighbours_within(cloud, point, runs, radius, indices, squared);
      return Neighbourhood{row, point, std::span(indices).first(count), std::span(squared).first(count)};
    };
    work(begin, end, search);
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, (rows.size() + kPart - 1) / kPart),
                    [&](const tbb::blocked_range<std::size_t>& parts) {
                      part(parts.begin() * kPart, std::min(rows.size(), parts.end() * kPart));
                    });
}

/// Calls visit(k, neighbourhood) for each of rows, in parallel.
template <typename Visit>
void visit_neighbourhoods(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius,
                          const Visit& visit) {
  search_in_parts(grid, rows, radius, [&](std::size_t begin, std::size_t end, const auto& search) {
    for (std::size_t k = begin; k < end; ++k) visit(k, search(k));
  });
}

}  // namespace consimd::features::detail
