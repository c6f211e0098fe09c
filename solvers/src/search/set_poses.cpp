#include "search/set_poses.hpp"

#include <algorithm>
#include <array>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/three_point_fit.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "sampling/sampling.hpp"
#include "support/row_blocks.hpp"

namespace consimd::detail {
PoseCandidate pose_of_set(const Correspondences& correspondences, const std::vector<std::uint32_t>& set,
                          double noise_bound, std::uint64_t seed, std::uint64_t hypothesis,
                          std::uint32_t support_to_beat, const ThreePointTuning& tuning, PoseScratch& scratch) {
  scratch.subset.assign_subset(correspondences, set);
  const CorrespondenceView subset = scratch.subset.view();
  CounterRandom random(seed, RandomStage::three_point, hypothesis);
  scratch.triples.resize(tuning.triples);
  scratch.poses.resize(tuning.triples);
  scratch.support.resize(tuning.triples);
  const auto best_of = [&](std::size_t first, std::size_t count) {
    const std::span<IndexTriple> triples = std::span(scratch.triples).subspan(first, count);
    for (IndexTriple& triple : triples) triple = draw_triple(random, static_cast<std::uint32_t>(set.size()));
    const std::span<WorkingPose> poses = std::span(scratch.poses).subspan(first, count);
    const std::span<PoseSupport> support = std::span(scratch.support).subspan(first, count);
    three_point_fits(subset, triples, poses);
    alignment_scores(subset, poses, noise_bound, support);
    const auto end = scratch.support.begin() + static_cast<std::ptrdiff_t>(first + count);
    return std::ranges::max_element(scratch.support.begin(), end, {}, &PoseSupport::score);
  };
  auto best = best_of(0, tuning.first_triples);
  // A set may hold a part of a pose's supporters only.
  const std::size_t wanted = std::min<std::size_t>(support_to_beat, set.size());
  if (best->score < tuning.support_share * static_cast<float>(wanted)) return {};
  if (best->score < tuning.enough_share * static_cast<float>(set.size())) {
    best = best_of(tuning.first_triples, tuning.triples - tuning.first_triples);
  }

  const WorkingPose minimal = scratch.poses[static_cast<std::size_t>(best - scratch.support.begin())];
  std::array<WorkingPose, 2> poses{minimal, minimal};
  for (int round = 0; round < 2; ++round) {
    const RigidFit fit = row_blocks::truncated_fit(subset, poses[1], noise_bound);
    if (!fit.determined()) break;
    poses[1] = to_working_pose(fit.pose);
  }
  std::array<PoseSupport, 2> support{};
  row_blocks::alignment_scores(correspondences, poses, noise_bound, support);
  return support[1].score > support[0].score ? PoseCandidate{poses[1], support[1]}
                                             : PoseCandidate{poses[0], support[0]};
}

float score_at_a_glance(const Correspondences& correspondences, std::span<const std::uint32_t> set, double noise_bound,
                        std::size_t glances, PoseScratch& scratch) {
  if (set.size() < 3) return 0.0F;
  scratch.subset.assign_subset(correspondences, set);
  const std::size_t others = set.size() - 2;
  scratch.triples.resize(std::min(others, glances));
  for (std::size_t i = 0; i < scratch.triples.size(); ++i) {
    scratch.triples[i] = {0, 1, static_cast<std::uint32_t>(2 + i * others / scratch.triples.size())};
  }
  scratch.poses.resize(scratch.triples.size());
  scratch.support.resize(scratch.triples.size());
  three_point_fits(scratch.subset, scratch.triples, scratch.poses);
  alignment_scores(scratch.subset, scratch.poses, noise_bound, scratch.support);
  return std::ranges::max_element(scratch.support, {}, &PoseSupport::score)->score;
}

}  // namespace consimd::detail
