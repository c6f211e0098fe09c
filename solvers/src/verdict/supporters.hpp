// The supporters of a pose, as evidence: how many there are, and how many of them tell of different places.
#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "verdict/strata.hpp"

namespace consimd::detail {

/// Supporters at one of the tested bounds.
struct Support {
  double count = 0.0;
  /// Those that count with each but the first of a place once: in input order, a supporter whose source is closer than
  /// the radius to that of one that counts already does not.
  double spread = 0.0;
};
using Supports = std::array<Support, kTestedBounds.size()>;

/// Counts those of `pose` at kTestedBounds times `noise_bound`, in time proportional to their number. noise_bound,
/// radius: caller's unit. `along`: directions, orthogonal to each other, along which a line is one place.
[[nodiscard]] Supports supports(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                                double radius, std::span<const Eigen::Vector3f> along = {});

}  // namespace consimd::detail
