#include <consimd/solvers/three_point_ransac.hpp>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/three_point_fit.hpp>

#include "call/option_checks.hpp"
#include "sampling/sampling.hpp"
#include "support/pose_candidate.hpp"

namespace consimd {

ThreePointResult three_point_ransac(const Correspondences& correspondences, std::span<const std::uint32_t> candidates,
                                    const ThreePointOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_confidence(options.confidence);
  ThreePointResult result;
  ConsensusSet& best = result.consensus;
  const auto size = static_cast<std::uint32_t>(candidates.size());
  if (size < 3) return result;

  const Correspondences subset = correspondences.subset(candidates);
  const CorrespondenceView view = subset.view();
  std::vector<IndexTriple> triples(detail::kBatch);
  std::vector<WorkingPose> poses(detail::kBatch);
  std::vector<std::uint32_t> counts(detail::kBatch);
  WorkingPose best_pose{};

  std::uint64_t needed = 1;
  while (best.iterations < options.max_iterations && best.iterations <= needed) {
    for (std::uint32_t h = 0; h < detail::kBatch; ++h) {
      detail::CounterRandom random(options.seed, detail::RandomStage::three_point, best.iterations + h);
      triples[h] = detail::draw_triple(random, size);
    }
    three_point_fits(view, triples, poses);
    tbb::parallel_for(std::uint32_t{0}, detail::kBatch / 8, [&](std::uint32_t eighth) {
      alignment_counts(view, std::span(poses).subspan(eighth * 8, 8), options.noise_bound,
                       std::span(counts).subspan(eighth * 8, 8));
    });
    const std::uint64_t first = best.iterations;
    for (std::uint32_t h = 0;
         h < detail::kBatch && best.iterations < options.max_iterations && best.iterations <= needed; ++h) {
      best.iterations = first + h + 1;
      if (counts[h] < best.score) continue;
      best.score = counts[h];
      best_pose = poses[h];
      needed = detail::iterations_needed(options.confidence, static_cast<double>(counts[h]) / size, 3);
    }
  }
  if (best.score < 3) return result;
  best.members = detail::pose_inliers(view, best_pose, options.noise_bound);
  for (std::uint32_t& member : best.members) member = candidates[member];
  std::sort(best.members.begin(), best.members.end());
  result.pose = from_working_pose(best_pose);
  return result;
}

}  // namespace consimd
