// Intrinsic shape signatures: the keypoints of a cloud.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct IssOptions {
  /// Radius of the neighbourhood that tells a point's saliency; caller's unit, > 0, at most the grid's cell.
  double radius = 0.0;
  /// A keypoint is the most salient point within this radius; caller's unit, > 0, at most the grid's cell.
  double suppression_radius = 0.0;
  /// Largest ratio of the second eigenvalue to the first, and of the third to the second, which are in descending
  /// order: above them the axes of a neighbourhood are any. In (0, 1].
  double second_to_first = 0.975;
  double third_to_second = 0.975;
  /// Neighbours, the point aside, that a keypoint has at least.
  std::size_t fewest_neighbours = 5;
};

/// ISS keypoints (Zhong, ICCV Workshops 2009), as rows of grid.cloud(), ascending. The saliency of a point is the
/// smallest eigenvalue of the covariance of its neighbourhood, all points weighing the same: a voxel grid stands in for
/// the paper's weights by density. Of equally salient points within the suppression radius the earlier one is kept. In
/// parallel; the same for any number of threads. Throws std::invalid_argument on bad options.
[[nodiscard]] std::vector<std::uint32_t> iss_keypoints(const CellGrid& grid, const IssOptions& options);

}  // namespace features
}  // namespace consimd
