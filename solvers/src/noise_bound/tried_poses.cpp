#include <cstdint>
#include <span>
#include <vector>

#include "noise_bound/bound_search.hpp"
#include "scale/rival_scale.hpp"
#include "support/best_poses.hpp"
#include "support/pose_candidate.hpp"
#include "verdict/final_pose.hpp"
#include "verdict/pose_checks.hpp"
#include "verdict/pose_test.hpp"

namespace consimd::detail {

Registration register_tried_poses(const Correspondences& correspondences, const BoundSearch& found,
                                  std::uint64_t seed) {
  const CallOptions asked{found.estimate.noise_bound, seed};
  return run_at_known_scale(
      correspondences, asked, [&](const Correspondences& rows, const CallOptions& options, Registration& result) {
        const double bound = options.noise_bound;
        BestPoses poses(rows, bound);
        for (const WorkingPose& other : std::span(found.poses).subspan(1)) {
          poses.offer(locally_optimise(rows, scored(rows.view(), other, bound), bound));
        }
        const PoseCandidate best = scored(rows.view(), found.poses.front(), bound);
        poses.promote(best);
        const std::vector<std::uint32_t> supporters = pose_inliers(rows.view(), best.pose, bound);
        std::vector<std::uint32_t> agreeing;
        if (supporters.size() >= 3) {
          agreeing = rows_agreeing_with(
              rows, {supporters.front(), supporters[supporters.size() / 2], supporters.back()}, bound);
        }
        finish_and_conclude(rows, {bound, found.estimate.bounds_tried}, poses, agreeing, true, result);
      });
}

}  // namespace consimd::detail
