// Correspondences that are all right by the caller's word: surveyed targets, a checked list.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace CONSIMD_EXPORT consimd {

/// What the points of both clouds determine of a pose.
enum class PointGeometry : std::uint8_t {
  determined,     ///< all of it
  contradictory,  ///< nothing: no motion fits, residuals are as large as the clouds
  collinear,      ///< the points of a cloud lie on a line, up to their residuals: the rotation about it is free
  coincident,     ///< the points of a cloud coincide, up to their residuals: any rotation would do
};

/// "determined", "contradictory", "collinear", "coincident".
[[nodiscard]] std::string_view to_string(PointGeometry geometry) noexcept;

struct AssumedInliers {
  /// status: success, too_few_correspondences or degenerate_geometry. The inliers are all rows; noise_bound is the
  /// largest residual; nothing is searched, so log10_false_poses is 0 and says nothing. The covariance is that of least
  /// squares with the deviation that the residuals show. `mirrored`, with the pose, where a reflection leaves less than
  /// a tenth of the deviation.
  Registration registration;
  PointGeometry geometry = PointGeometry::determined;
  /// |R p + t - q| of each row, caller's unit. Empty without a pose.
  std::vector<double> residuals;
  /// Standard deviation of a residual per axis with 3 N - 6 degrees of freedom, caller's unit. With three or four rows
  /// a pose fits nearly anything: few degrees of freedom make this a rough number.
  double sigma = 0.0;
  /// The scale of the sources with which less than a tenth of the deviation is left; none where none does.
  std::optional<double> other_scale;
  /// The row without which less than a tenth of the deviation is left, likely a wrong one; none where there is none,
  /// and of fewer than five rows, which are too few to tell.
  std::optional<std::uint32_t> odd_row;
};

/// The least-squares pose of all correspondences (Kabsch 1976, Horn 1987), three or more, every one taken as right:
/// the corners of a rectangle or three targets do. A wrong row moves the pose as much as a right one. Computed in
/// double on coordinates that the working frame holds in single precision, a 2^-24 of the extent. Throws
/// std::invalid_argument where rows are far from all others (Correspondences::far_rows), which can hardly be right.
[[nodiscard]] AssumedInliers register_assumed_inliers(const Correspondences& correspondences);

}  // namespace consimd
