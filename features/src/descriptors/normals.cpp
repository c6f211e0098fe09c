#include <consimd/features/normals.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "grid/neighbourhoods.hpp"

namespace consimd::features {
namespace {

/// Which way a normal is to point from where it is.
class Orientation {
 public:
  Orientation(const Cloud& cloud, const std::optional<std::array<double, 3>>& viewpoint) {
    if (!viewpoint) return;
    for (const double x : *viewpoint) {
      if (!std::isfinite(x)) {
        throw std::invalid_argument("viewpoint has a coordinate " + std::to_string(x) + ", expected finite ones");
      }
    }
    viewpoint_ = cloud.to_working_frame(*viewpoint);
  }

  [[nodiscard]] bool turns(const std::array<float, 3>& point, const std::array<float, 3>& normal) const {
    if (!viewpoint_) {
      const float last = normal[2] != 0.0f ? normal[2] : normal[1] != 0.0f ? normal[1] : normal[0];
      return last < 0.0f;
    }
    double towards = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      towards += static_cast<double>(normal[c]) * ((*viewpoint_)[c] - static_cast<double>(point[c]));
    }
    return towards < 0.0;
  }

 private:
  std::optional<std::array<double, 3>> viewpoint_;
};

}  // namespace

void estimate_normals(CellGrid& grid, const NormalOptions& options) {
  detail::require_radius(grid, options.radius, "normal radius");
  const Orientation orientation(grid.cloud(), options.viewpoint);
  const std::vector<std::uint32_t> rows = detail::all_rows(grid.size());
  std::array<std::vector<float>, 3> normals;
  for (auto& axis : normals) axis.resize(grid.size());
  const CloudView cloud = grid.cloud().view();

  detail::search_in_parts(grid, rows, options.radius, [&](std::size_t begin, std::size_t end, const auto& search) {
    constexpr std::size_t kFewest = 3;
    for (; begin < end; begin += ScatterBatch::kSize) {
      const std::size_t count = std::min(ScatterBatch::kSize, end - begin);
      ScatterBatch scatter{};
      PrincipalAxes axes;
      for (std::size_t k = 0; k < count; ++k) {
        const detail::Neighbourhood near = search(begin + k);
        const std::array<float, 6> entries = near.rows.size() < kFewest
                                                 ? std::array<float, 6>{}
                                                 : neighbourhood_scatter(cloud, near.point, near.rows, options.radius);
        for (std::size_t e = 0; e < 6; ++e) scatter.entries[e][k] = entries[e];
      }
      principal_axes(scatter, count, axes);
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t row = begin + k;
        std::array<float, 3> normal{axes.smallest_axes[0][k], axes.smallest_axes[1][k], axes.smallest_axes[2][k]};
        // No spread at all: too few points, or all of them the same.
        if (!(axes.values[2][k] > 0.0f)) normal.fill(std::numeric_limits<float>::quiet_NaN());
        const std::array<float, 3> point{cloud.points(0)[row], cloud.points(1)[row], cloud.points(2)[row]};
        const float sign = orientation.turns(point, normal) ? -1.0f : 1.0f;
        for (std::size_t c = 0; c < 3; ++c) normals[c][row] = sign * normal[c];
      }
    }
  });
  grid.set_normals({normals[0].data(), normals[1].data(), normals[2].data()});
}

}  // namespace consimd::features
