#include <consimd/features/normals.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "grid/principal_axes.hpp"

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
  std::array<std::vector<float>, 3> normals;
  for (auto& axis : normals) axis.resize(grid.size());
  const CloudView cloud = grid.cloud().view();
  constexpr std::size_t kFewest = 3;
  const auto write = [&](std::size_t row, std::size_t /*points*/, const PrincipalAxes& axes, std::size_t k) {
    std::array<float, 3> normal{axes.smallest_axes[0][k], axes.smallest_axes[1][k], axes.smallest_axes[2][k]};
    // No spread at all: too few points, or all of them the same.
    if (!(axes.values[2][k] > 0.0f)) normal.fill(std::numeric_limits<float>::quiet_NaN());
    const std::array<float, 3> point{cloud.points(0)[row], cloud.points(1)[row], cloud.points(2)[row]};
    const float sign = orientation.turns(point, normal) ? -1.0f : 1.0f;
    for (std::size_t c = 0; c < 3; ++c) normals[c][row] = sign * normal[c];
  };
  detail::visit_principal_axes(grid, options.radius, kFewest, write);
  grid.set_normals({normals[0].data(), normals[1].data(), normals[2].data()});
}

}  // namespace consimd::features
