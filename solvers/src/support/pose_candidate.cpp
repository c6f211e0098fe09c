#include "support/pose_candidate.hpp"

#include <array>
#include <span>

#include <consimd/kernels/alignment_residuals.hpp>

#include "bits/bit_rows.hpp"
#include "support/row_blocks.hpp"

namespace consimd::detail {
namespace {

// Bounds of the refits, in noise bounds: wide first, since the start may be off by more than the noise; wider where it
// may hang on a part of the supporters.
constexpr std::array kLocalBounds{1.5, 1.25, 1.0, 1.0, 1.0};
constexpr std::array kWideBounds{3.0, 2.5, 2.0, 1.5, 1.25, 1.0, 1.0};
constexpr double kSmallPart = 0.25;

PoseCandidate refitted_within(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound,
                              std::span<const double> bounds) {
  const CorrespondenceView view = correspondences.view();
  // Refits look at the neighbourhood alone where that is a small part.
  Correspondences near;
  if (start.support.count < kSmallPart * static_cast<double>(view.size())) {
    near = correspondences.subset(pose_inliers(view, start.pose, 2.0 * bounds.front() * noise_bound));
  }
  const CorrespondenceView refitted = near.empty() ? view : near.view();
  PoseCandidate best = start;
  PoseCandidate current = start;
  for (const double bound : bounds) {
    const RigidFit fit = row_blocks::truncated_fit(refitted, current.pose, bound * noise_bound);
    if (!fit.determined()) break;
    current.pose = to_working_pose(fit.pose);
    row_blocks::alignment_scores(view, std::span(&current.pose, 1), noise_bound, std::span(&current.support, 1));
    if (current.support.score > best.support.score) best = current;
  }
  return best;
}

}  // namespace

PoseCandidate scored(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  PoseCandidate result{pose, {}};
  alignment_scores(view, std::span(&result.pose, 1), noise_bound, std::span(&result.support, 1));
  return result;
}

PoseCandidate scored(const Correspondences& correspondences, const RigidTransform& T_target_source,
                     double noise_bound) {
  return scored(correspondences.view(), to_working_pose(to_working_frame(T_target_source, correspondences)),
                noise_bound);
}

PoseCandidate locally_optimise(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound) {
  return refitted_within(correspondences, start, noise_bound, kLocalBounds);
}

PoseCandidate widely_optimise(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound) {
  return refitted_within(correspondences, locally_optimise(correspondences, start, noise_bound), noise_bound,
                         kWideBounds);
}

std::vector<std::uint32_t> pose_inliers(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  std::vector<std::uint64_t> bits(view.words());
  std::vector<std::uint32_t> inliers;
  inliers.reserve(row_blocks::alignment_bits(view, pose, noise_bound, bits));
  members_of(bits, inliers);
  return inliers;
}

}  // namespace consimd::detail
