// Correspondences from clouds and matches of the Point Cloud Library's shape. Templates on what these types look like:
// PCL itself is not needed.
#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/point_ranges.hpp>

namespace CONSIMD_EXPORT consimd {

/// pcl::PointCloud of any point type with x, y, z.
template <typename C>
concept PclCloud = std::ranges::contiguous_range<decltype(std::declval<const C&>().points)> &&
    PointStruct<std::ranges::range_value_t<decltype(std::declval<const C&>().points)>>;

/// pcl::Correspondences: a container of matches with index_query (source) and index_match (target).
template <typename M>
concept PclMatches = std::ranges::random_access_range<const M> && requires(std::ranges::range_value_t<M> m) {
  requires std::integral<decltype(m.index_query)> && std::integral<decltype(m.index_match)>;
};

namespace pcl_rows {

/// Coordinates of the chosen points of a cloud, N x 3.
template <typename Cloud, typename Matches, typename Index>
auto gather(const Cloud& cloud, const Matches& matches, Index index, const char* name, const char* role) {
  using T = std::remove_cvref_t<decltype(cloud.points.data()->x)>;
  std::vector<T> rows;
  rows.reserve(3 * std::ranges::size(matches));
  std::size_t row = 0;
  for (const auto& match : matches) {
    const auto i = match.*index;
    if (std::cmp_less(i, 0) || std::cmp_greater_equal(i, cloud.points.size())) {
      throw std::invalid_argument("match " + std::to_string(row) + ": " + name + " is " + std::to_string(i) +
                                  ", expected a point of the " + role + " cloud, which has " +
                                  std::to_string(cloud.points.size()));
    }
    const auto& point = cloud.points[static_cast<std::size_t>(i)];
    rows.insert(rows.end(), {point.x, point.y, point.z});
    ++row;
  }
  return rows;
}

}  // namespace pcl_rows

/// Correspondence k: the point index_query of `source` and the point index_match of `target` that matches[k] names, so
/// inliers are rows of `matches`. Throws std::invalid_argument naming row and value at an index outside its cloud (PCL
/// leaves -1 where it found no match) or, as `Correspondences` does, at a coordinate that is not finite.
template <PclCloud Source, PclCloud Target, PclMatches Matches>
[[nodiscard]] Correspondences pcl_correspondences(const Source& source, const Target& target, const Matches& matches) {
  using Match = std::ranges::range_value_t<Matches>;
  const auto p = pcl_rows::gather(source, matches, &Match::index_query, "index_query", "source");
  const auto q = pcl_rows::gather(target, matches, &Match::index_match, "index_match", "target");
  using Points = PointSpan<typename decltype(p)::value_type>;
  return {Points::interleaved(p.data(), p.size() / 3), Points::interleaved(q.data(), q.size() / 3)};
}

/// Correspondence k: point k of `source` and point k of `target`, without a copy in between.
template <PclCloud Source, PclCloud Target>
[[nodiscard]] Correspondences pcl_correspondences(const Source& source, const Target& target) {
  return {range_points(source.points), range_points(target.points)};
}

/// The chosen rows of `matches`, in the given order and in a container of the same type: with Registration::inliers,
/// what PCL's rejectors return. Throws std::out_of_range on a bad row.
template <PclMatches Matches>
[[nodiscard]] Matches matches_subset(const Matches& matches, std::span<const std::uint32_t> rows) {
  Matches chosen;
  for (const std::uint32_t row : rows) {
    if (row >= matches.size()) {
      throw std::out_of_range("row " + std::to_string(row) + " of " + std::to_string(matches.size()) + " matches");
    }
    chosen.push_back(matches[row]);
  }
  return chosen;
}

}  // namespace consimd
