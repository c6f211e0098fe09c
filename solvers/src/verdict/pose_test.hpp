// What a pose that a search has found is held against.
#pragma once

#include <cstdint>
#include <memory>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// log10 of the number of false poses below which a support is significant.
inline constexpr double kSignificant = -3.0;
/// From here on a glance is enough.
inline constexpr double kBeyondDoubt = -4.5;
/// The same of another motion that makes the best pose ambiguous: a coin toss is no reason for doubt.
inline constexpr double kSignificantRival = kSignificant - 1.0;

class Background;

/// All poses of a registration are held against one.
struct PoseTest {
  double noise_bound = 0.0;        ///< caller's unit
  std::uint32_t bounds_tried = 1;  ///< that `noise_bound` was chosen from by looking at the data
  /// Measured when a pose is first looked at closely, and kept for the next.
  mutable std::shared_ptr<const Background> background = nullptr;

  /// A close look; the bounds tried do not count. Where it is not below `enough` there may be more. All calls are given
  /// the same correspondences.
  [[nodiscard]] double log10_false_poses(const Correspondences& correspondences, const WorkingPose& pose,
                                         double enough = 0.0) const;
};

}  // namespace consimd::detail
