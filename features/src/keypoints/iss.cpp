#include <consimd/features/iss.hpp>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "grid/principal_axes.hpp"

namespace consimd::features {
namespace {

void require_ratio(double ratio, const char* name) {
  if (ratio > 0.0 && ratio <= 1.0) return;
  throw std::invalid_argument(std::string(name) + " is " + std::to_string(ratio) + ", expected above 0, at most 1");
}

}  // namespace

std::vector<std::uint32_t> iss_keypoints(const CellGrid& grid, const IssOptions& options) {
  detail::require_radius(grid, options.radius, "radius");
  detail::require_radius(grid, options.suppression_radius, "suppression_radius");
  require_ratio(options.second_to_first, "second_to_first");
  require_ratio(options.third_to_second, "third_to_second");

  // The number of points cancels out of the ratios, but not where points are compared.
  std::vector<float> saliencies(grid.size(), 0.0f);
  const auto second_to_first = static_cast<float>(options.second_to_first);
  const auto third_to_second = static_cast<float>(options.third_to_second);
  detail::visit_principal_axes(
      grid, options.radius, options.fewest_neighbours + 1,
      [&](std::size_t row, std::size_t points, const PrincipalAxes& axes, std::size_t k) {
        const float third = axes.values[0][k];
        const float second = axes.values[1][k];
        const float first = axes.values[2][k];
        if (third > 0.0f && second < second_to_first * first && third < third_to_second * second) {
          saliencies[row] = third / static_cast<float>(points);
        }
      });

  std::vector<std::uint32_t> salient;
  for (std::uint32_t row = 0; row < grid.size(); ++row) {
    if (saliencies[row] > 0.0f) salient.push_back(row);
  }
  std::vector<std::uint8_t> kept(salient.size(), 0);
  detail::visit_neighbourhoods(grid, salient, options.suppression_radius,
                               [&](std::size_t k, const detail::Neighbourhood& near) {
                                 const float own = saliencies[near.row];
                                 kept[k] = std::none_of(near.rows.begin(), near.rows.end(), [&](std::uint32_t row) {
                                   return saliencies[row] > own || (saliencies[row] == own && row < near.row);
                                 });
                               });
  std::vector<std::uint32_t> keypoints;
  for (std::size_t k = 0; k < salient.size(); ++k) {
    if (kept[k] != 0) keypoints.push_back(salient[k]);
  }
  return keypoints;
}

}  // namespace consimd::features
