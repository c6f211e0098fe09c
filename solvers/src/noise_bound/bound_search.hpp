// The search for a noise bound, and a registration from what it met.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/noise_bound.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/stop_condition.hpp>

namespace consimd::detail {

/// Name of the stage that a registration without a given bound has before all others.
inline constexpr const char* kNoiseBoundStage = "noise_bound";

struct BoundSearch {
  NoiseBoundEstimate estimate;
  /// The pose that the estimate rests on and then all that were tried, if that pose is significant but not beyond
  /// doubt, or no time is left: a solver may miss it. Else none.
  std::vector<WorkingPose> poses;
};

/// See estimate_noise_bound.
BoundSearch search_noise_bound(const Correspondences& correspondences, std::uint64_t seed,
                               const StopCondition& stop = {});

/// The registration of the pose that an estimate rests on, the others being what it has to stand up to. `found` has
/// poses.
Registration register_tried_poses(const Correspondences& correspondences, const BoundSearch& found, std::uint64_t seed);

/// Rows that tell of different places, ascending, the bound at which they do, and what is left of chance among them.
struct IndependentRows {
  std::vector<std::uint32_t> rows;
  NoiseBoundEstimate estimate;  ///< log10_false_poses: 0 where there are no rows
};

/// For where nothing was found among all rows: places that recur, in each frame of a camera at rest, outweigh those
/// that do not, and their rows, which agree in length with each other, make every pose look like chance. The rows that
/// stand for all of them are searched at each bound, and held against chance among themselves; that there were all rows
/// before makes twice the bounds.
IndependentRows search_independent_bound(const Correspondences& correspondences, std::uint64_t seed,
                                         const StopCondition& stop = {});

/// A registration of independent rows, the last of so many tries, with the inliers among all rows; refused where all
/// rows give its pose by chance.
void bring_to_all_rows(const Correspondences& correspondences, std::uint32_t tries, Registration& result);

/// Whether a pose that was found with an estimated bound is what chance gives once the bound is that of its residuals:
/// structure makes some poses significant at bounds that are not theirs. Caller's frame and unit.
bool is_chance_at_its_noise(const Correspondences& correspondences, const RigidTransform& T_target_source,
                            double noise_bound);

}  // namespace consimd::detail
