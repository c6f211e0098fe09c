#include "support/hypothesis_selection.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>

#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

constexpr std::size_t kPosesPerTask = 16;
// Hypotheses of this share of the best pose's support are refined: those of few correspondences are noisy, and rivals
// count down to four fifths.
constexpr float kWorthOptimising = 0.4F;
// Refits cost far more than scores. The first hypotheses are all refined, since refits of one motion may end at
// different poses; of the others those that are another motion.
constexpr int kAlwaysOptimised = 6;
constexpr int kMostOptimised = 32;

}  // namespace

std::optional<std::size_t> select_pose(const Correspondences& correspondences, std::span<const WorkingPose> hypotheses,
                                       double noise_bound, PoseRanking ranking, BestPoses& poses,
                                       double ranking_tolerance) {
  std::vector<PoseSupport> support(hypotheses.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, hypotheses.size(), kPosesPerTask), [&](const auto& range) {
    alignment_scores(correspondences, hypotheses.subspan(range.begin(), range.size()), ranking_tolerance * noise_bound,
                     std::span(support).subspan(range.begin(), range.size()));
  });
  const auto rank = [&](std::size_t h) {
    return ranking == PoseRanking::inlier_count ? static_cast<float>(support[h].count) : support[h].score;
  };
  float highest = 0.0F;
  for (std::size_t h = 0; h < support.size(); ++h) highest = std::max(highest, rank(h));
  std::vector<std::size_t> promising;
  for (std::size_t h = 0; h < support.size(); ++h) {
    if (support[h].count >= 3 && rank(h) >= kWorthOptimising * highest) promising.push_back(h);
  }
  std::ranges::stable_sort(promising, std::ranges::greater{}, rank);

  std::optional<std::size_t> chosen;
  int optimised = 0;
  for (const std::size_t h : promising) {
    if (optimised >= kAlwaysOptimised && poses.same_motion_as_best(hypotheses[h])) continue;
    PoseCandidate candidate{hypotheses[h], support[h]};
    if (ranking_tolerance != 1.0) {
      alignment_scores(correspondences, std::span(&candidate.pose, 1), noise_bound, std::span(&candidate.support, 1));
    }
    if (poses.offer(locally_optimise(correspondences, candidate, noise_bound))) chosen = h;
    if (++optimised == kMostOptimised) break;
  }
  return chosen;
}

}  // namespace consimd::detail
