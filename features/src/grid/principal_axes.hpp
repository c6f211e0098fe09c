// How the points around each point of a cloud spread.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/neighbourhoods.hpp>

#include "grid/neighbourhoods.hpp"

namespace consimd::features::detail {

/// Calls visit(row, points, axes, k) for every row of the grid, in parallel: entry k of `axes` is that of the scatter
/// of the row's neighbourhood of so many points, the row among them; without spread where these are fewer than
/// `fewest`.
template <typename Visit>
void visit_principal_axes(const CellGrid& grid, double radius, std::size_t fewest, const Visit& visit) {
  const std::vector<std::uint32_t> rows = all_rows(grid.size());
  const CloudView cloud = grid.cloud().view();
  search_in_parts(grid, rows, radius, [&](std::size_t begin, std::size_t end, const auto& search) {
    for (; begin < end; begin += ScatterBatch::kSize) {
      const std::size_t count = std::min(ScatterBatch::kSize, end - begin);
      ScatterBatch scatter{};
      PrincipalAxes axes;
      std::array<std::size_t, ScatterBatch::kSize> points;
      for (std::size_t k = 0; k < count; ++k) {
        const Neighbourhood near = search(begin + k);
        points[k] = near.rows.size();
        const std::array<float, 6> entries = near.rows.size() < fewest
                                                 ? std::array<float, 6>{}
                                                 : neighbourhood_scatter(cloud, near.point, near.rows, radius);
        for (std::size_t e = 0; e < 6; ++e) scatter.entries[e][k] = entries[e];
      }
      principal_axes(scatter, count, axes);
      for (std::size_t k = 0; k < count; ++k) visit(begin + k, points[k], axes, k);
    }
  });
}

}  // namespace consimd::features::detail
