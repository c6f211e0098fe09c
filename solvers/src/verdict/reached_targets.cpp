#include "verdict/reached_targets.hpp"

#include <cmath>

#include "support/point_cells.hpp"
#include "support/points.hpp"

namespace consimd::detail {

std::vector<ReachedTarget> reached_targets(const CorrespondenceView& view, const WorkingPose& pose, double bound) {
  const double radius = bound * view.scale();
  const auto limit = static_cast<float>(radius * radius);
  const PointCells targets(view.size(), radius, [&](std::uint32_t row) { return target_point(view, row); });
  std::vector<ReachedTarget> reached;
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    const Point p = moved(pose, source_point(view, row));
    if (std::isnan(p.x)) continue;  // a far row
    targets.visit(p, limit, [&](std::uint32_t target, float squared) { reached.push_back({row, target, squared}); });
  }
  return reached;
}

}  // namespace consimd::detail
