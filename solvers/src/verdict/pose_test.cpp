#include "verdict/pose_test.hpp"

#include <numbers>

#include "verdict/background.hpp"

namespace consimd::detail {

double PoseTest::log10_false_poses(const Correspondences& correspondences, const WorkingPose& pose,
                                   double enough) const {
  if (correspondences.size() < 3) return 0.0;
  if (!background) background = std::make_shared<Background>(correspondences, noise_bound);
  return background->log_false_poses(pose, enough * std::numbers::ln10) / std::numbers::ln10;
}

}  // namespace consimd::detail
