// Surface normals.
#pragma once

#include <array>
#include <optional>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct NormalOptions {
  /// Radius of the neighbourhood whose plane gives the normal; caller's unit, > 0, at most the grid's cell.
  double radius = 0.0;
  /// Where the scan was taken from, in the caller's frame: normals point towards it. None: of a normal's components the
  /// last that is not 0 is positive, which two scans agree on only where they are upright.
  std::optional<std::array<double, 3>> viewpoint = std::array<double, 3>{0.0, 0.0, 0.0};
};

/// Gives every point of the grid the normal of its neighbourhood: the direction in which the points within the radius
/// spread least (smallest principal axis of their covariance), NaN where there are fewer than three. In parallel; the
/// same for any number of threads. Throws std::invalid_argument on a bad radius, or a viewpoint that is not finite.
void estimate_normals(CellGrid& grid, const NormalOptions& options);

}  // namespace features
}  // namespace consimd
