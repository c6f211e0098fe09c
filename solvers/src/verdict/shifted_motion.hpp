// Repeated structure: the motion that differs from a pose by a shift alone.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "support/best_poses.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {

/// Other motions that repeat a pose.
struct RepeatedMotions {
  PoseCandidate best;               ///< that of most support, brought into place; without support where there is none
  std::vector<double> independent;  ///< supporters of the best ones that count, most first
  /// Motions that were looked at, whatever the rows are; none where each row tells one, and so do all that support it.
  std::optional<double> looked_at = std::nullopt;
};

/// Poses with the rotation of the best one that rows agree on which it misses by more than kNearMisses bounds: matches
/// of a window with any other support many shifts of a facade alike. Finds those that most rows agree on. noise_bound:
/// caller's unit.
RepeatedMotions shifted_motions(const Correspondences& correspondences, const BestPoses& poses, double noise_bound);

/// ln of the chance that so many motions are supported as well as these, where one takes a source to the target of any
/// other of `size` rows with a chance of `chance`.
double log_chance_of(const RepeatedMotions& motions, double size, double chance);

}  // namespace consimd::detail
