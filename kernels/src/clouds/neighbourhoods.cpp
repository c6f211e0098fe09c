#include <consimd/kernels/neighbourhoods.hpp>

#include <algorithm>

#include <stdexcept>
#include <string>

#include "../dispatch.hpp"
#include "cloud_arguments.hpp"

namespace consimd {

namespace {

/// Throws std::out_of_range on a run beyond the cloud. Returns how many points the runs hold.
std::size_t points_of(std::span<const PointRun> runs, const CloudView& cloud) {
  std::size_t points = 0;
  for (const PointRun& run : runs) {
    if (run.first > run.last || run.last > cloud.size()) {
      throw std::out_of_range("run from " + std::to_string(run.first) + " to " + std::to_string(run.last) + " of " +
                              std::to_string(cloud.size()) + " points");
    }
    points += run.last - run.first;
  }
  return points;
}

}  // namespace

std::size_t neighbours_within(const CloudView& cloud, const std::array<float, 3>& query, std::span<const PointRun> runs,
                              double radius, std::span<std::uint32_t> indices, std::span<float> squared_distances) {
  const float length = detail::working_length(cloud, radius, "radius");
  const std::size_t candidates = points_of(runs, cloud);
  if (indices.size() < candidates + kNeighbourSlack || squared_distances.size() < candidates + kNeighbourSlack) {
    throw std::invalid_argument("room for " + std::to_string(std::min(indices.size(), squared_distances.size())) +
                                " neighbours, expected " + std::to_string(candidates + kNeighbourSlack));
  }
  return detail::active_table().clouds.neighbours_within(detail::raw_points(cloud), query.data(), runs.data(),
                                                         runs.size(), length, indices.data(), squared_distances.data());
}

std::size_t nearest_within(const CloudView& cloud, const std::array<float, 3>& query, std::span<const PointRun> runs,
                           double radius, std::span<std::uint32_t> indices, std::span<float> squared_distances) {
  const float length = detail::working_length(cloud, radius, "radius");
  points_of(runs, cloud);
  if (indices.empty() || indices.size() != squared_distances.size()) {
    throw std::invalid_argument("room for " + std::to_string(indices.size()) + " indices and " +
                                std::to_string(squared_distances.size()) +
                                " distances, expected as many of both, one or more");
  }
  return detail::active_table().clouds.nearest_within(detail::raw_points(cloud), query.data(), runs.data(), runs.size(),
                                                      length, indices.size(), indices.data(), squared_distances.data());
}

std::array<float, 6> neighbourhood_scatter(const CloudView& cloud, const std::array<float, 3>& centre,
                                           std::span<const std::uint32_t> indices, double radius) {
  if (indices.empty()) throw std::invalid_argument("a neighbourhood of 0 points, expected one or more");
  const float unit = detail::working_length(cloud, radius, "radius");
  detail::require_points(indices, cloud.size());
  std::array<float, 6> scatter{};
  detail::active_table().clouds.neighbourhood_scatter(detail::raw_points(cloud), centre.data(), indices.data(),
                                                      indices.size(), unit, scatter.data());
  return scatter;
}

void principal_axes(const ScatterBatch& scatter, std::size_t n, PrincipalAxes& axes) {
  if (n > ScatterBatch::kSize) {
    throw std::invalid_argument("n is " + std::to_string(n) + ", expected at most " +
                                std::to_string(ScatterBatch::kSize));
  }
  const float* entries[6];
  for (std::size_t k = 0; k < 6; ++k) entries[k] = scatter.entries[k];
  float* const smallest[3] = {axes.smallest_axes[0], axes.smallest_axes[1], axes.smallest_axes[2]};
  float* const values[3] = {axes.values[0], axes.values[1], axes.values[2]};
  detail::active_table().clouds.principal_axes(entries, n, smallest, values);
}

}  // namespace consimd
