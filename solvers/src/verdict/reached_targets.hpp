// What a pose reaches: the pairs of a source and a target that it brings together, in whatever rows they are.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// The pose takes the source of one row near the target of another.
struct ReachedTarget {
  std::uint32_t source_row;
  std::uint32_t target_row;
  float squared;  ///< residual, working frame
};

/// All of them within `bound` (caller's unit), in the order of the sources' rows. Time and memory grow with their
/// number.
std::vector<ReachedTarget> reached_targets(const CorrespondenceView& view, const WorkingPose& pose, double bound);

}  // namespace consimd::detail
