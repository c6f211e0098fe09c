// The best pose of a search and the best of those that are another motion.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/pose_candidate.hpp"
#include "support/supported_motion.hpp"

namespace consimd::detail {

class BestPoses {
 public:
  /// Keeps a pointer to the correspondences.
  BestPoses(const Correspondences& correspondences, double noise_bound);

  /// Keeps a candidate that is better than the best pose, or another motion and better than the runner-up.
  /// Returns whether it is the best pose now.
  bool offer(const PoseCandidate& candidate);

  /// Makes `candidate` the best pose, whatever its score; the former best pose is the runner-up if that is another
  /// motion.
  void promote(const PoseCandidate& candidate);

  /// Support.count below 3: none.
  [[nodiscard]] const PoseCandidate& best() const noexcept { return best_; }
  [[nodiscard]] const PoseCandidate& runner_up() const noexcept { return runner_up_; }

  /// Whether the pose moves the best pose's supporters where that does (kSameMotion).
  [[nodiscard]] bool same_motion_as_best(const WorkingPose& pose) const { return best_motion_.is_same(pose); }
  /// Whether the best pose, or the runner-up, takes the row's source to within twice the noise bound of its target.
  [[nodiscard]] bool best_explains(std::uint32_t row) const { return explains(best_, row); }
  [[nodiscard]] bool runner_up_explains(std::uint32_t row) const { return explains(runner_up_, row); }

 private:
  void set_best(const PoseCandidate& candidate);
  [[nodiscard]] bool explains(const PoseCandidate& candidate, std::uint32_t row) const;

  const Correspondences* correspondences_;
  double noise_bound_;
  PoseCandidate best_;
  SupportedMotion best_motion_;
  PoseCandidate runner_up_;
};

}  // namespace consimd::detail
