#include <consimd/features/cell_grid.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "grid/cell_keys.hpp"
#include "grid/neighbourhoods.hpp"

namespace consimd::features {

CellGrid::CellGrid(const Cloud& cloud, double cell) : cell_(cell) {
  // A little more than asked for, so that rounding takes no neighbour at the very radius beyond the next cell.
  const detail::CellKeys key_of(cloud, (1.0 + 1e-5) * cell, "cell");
  strides_ = key_of.strides();
  low_ = key_of.low();
  per_length_ = key_of.per_length();
  std::vector<std::uint64_t> keys(cloud.size());
  for (std::size_t i = 0; i < keys.size(); ++i) keys[i] = key_of(i);
  order_ = detail::sorting_order(keys);
  cloud_ = cloud.subset(order_);
  for (std::uint32_t row = 0; row < order_.size(); ++row) {
    const std::uint64_t key = keys[order_[row]];
    if (!keys_.empty() && key == keys_.back()) continue;
    keys_.push_back(key);
    firsts_.push_back(row);
  }
  firsts_.push_back(static_cast<std::uint32_t>(order_.size()));
  if (keys_.empty()) return;
  // About two buckets a cell: most hold one cell or none.
  while (keys_.back() >> bucket_bits_ >= 2 * keys_.size()) ++bucket_bits_;
  buckets_.resize((keys_.back() >> bucket_bits_) + 2, static_cast<std::uint32_t>(keys_.size()));
  for (std::size_t c = keys_.size(); c-- > 0;) {
    buckets_[keys_[c] >> bucket_bits_] = static_cast<std::uint32_t>(c);
  }
  for (std::size_t bucket = buckets_.size() - 1; bucket-- > 0;) {
    buckets_[bucket] = std::min(buckets_[bucket], buckets_[bucket + 1]);
  }
}

NeighbourLists radius_neighbours(const CellGrid& grid, std::span<const std::uint32_t> rows, double radius) {
  detail::require_radius(grid, radius, "radius");
  detail::require_ascending(rows, grid.size());
  std::vector<std::vector<std::uint32_t>> found(rows.size());
  std::vector<std::vector<float>> squared(rows.size());
  detail::visit_neighbourhoods(grid, rows, radius, [&](std::size_t k, const detail::Neighbourhood& near) {
    found[k].assign(near.rows.begin(), near.rows.end());
    squared[k].assign(near.squared_distances.begin(), near.squared_distances.end());
  });
  NeighbourLists lists{{0}, {}, {}};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    lists.rows.insert(lists.rows.end(), found[k].begin(), found[k].end());
    for (const float s : squared[k]) {
      lists.distances.push_back(std::sqrt(static_cast<double>(s)) / grid.cloud().scale());
    }
    lists.starts.push_back(lists.rows.size());
  }
  return lists;
}

NearestLists nearest_neighbours(const CellGrid& grid, std::span<const std::array<double, 3>> queries, std::size_t most,
                                double radius) {
  detail::require_radius(grid, radius, "radius");
  constexpr std::size_t kMost = 64;
  if (most < 1 || most > kMost) {
    throw std::invalid_argument("most is " + std::to_string(most) + ", expected 1 to " + std::to_string(kMost));
  }
  NearestLists lists{most, std::vector<std::uint32_t>(most * queries.size(), NearestLists::kNone),
                     std::vector<double>(most * queries.size(), std::numeric_limits<double>::infinity())};
  constexpr std::size_t kPart = 256;
  const CloudView cloud = grid.cloud().view();
  const auto part = [&](std::size_t begin, std::size_t end) {
    detail::CellWalk walk(grid);
    std::array<float, kMost> squared;
    for (std::size_t k = begin; k < end; ++k) {
      const std::array<double, 3> p = grid.cloud().to_working_frame(queries[k]);
      const std::array<float, 3> query{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
      const std::size_t count =
          nearest_within(cloud, query, walk.runs_within(query, radius), radius,
                         std::span(lists.rows).subspan(k * most, most), std::span(squared).first(most));
      for (std::size_t rank = 0; rank < count; ++rank) {
        lists.distances[k * most + rank] = std::sqrt(static_cast<double>(squared[rank])) / cloud.scale();
      }
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, queries.size(), kPart),
                    [&](const tbb::blocked_range<std::size_t>& range) { part(range.begin(), range.end()); });
  return lists;
}

double resolution(const CellGrid& grid) {
  if (grid.size() == 0) throw std::invalid_argument("the cloud is empty: it has no resolution");
  constexpr std::size_t kSampled = 2000;
  std::vector<std::uint32_t> rows;
  const std::size_t step = (grid.size() + kSampled - 1) / kSampled;
  for (std::size_t row = 0; row < grid.size(); row += step) rows.push_back(static_cast<std::uint32_t>(row));
  std::vector<float> nearest(rows.size(), std::numeric_limits<float>::infinity());
  detail::visit_neighbourhoods(grid, rows, grid.cell(), [&](std::size_t k, const detail::Neighbourhood& near) {
    for (std::size_t j = 0; j < near.rows.size(); ++j) {
      if (near.rows[j] != near.row) nearest[k] = std::min(nearest[k], near.squared_distances[j]);
    }
  });
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return std::sqrt(static_cast<double>(*middle)) / grid.cloud().scale();
}

}  // namespace consimd::features
