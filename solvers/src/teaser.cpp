#include <consimd/solvers/teaser.hpp>

#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/solvers/adaptive_voting.hpp>
#include <consimd/solvers/maximum_clique.hpp>

#include "final_pose.hpp"
#include "option_checks.hpp"
#include "set_poses.hpp"
#include "stage_clock.hpp"

namespace consimd {
namespace {

/// The correspondences that TEASER estimates from.
struct Selected {
  std::vector<std::uint32_t> rows;
  bool proven = true;
  std::uint64_t nodes = 0;
};

Selected select(const ConsistencyMatrix& matrix, const TeaserOptions& options) {
  Selected selected;
  switch (options.selection) {
    case TeaserOptions::Selection::maximum_clique: {
      MaximumClique clique = maximum_clique(matrix, {options.max_nodes});
      selected = {std::move(clique.members), clique.proven, clique.nodes};
      break;
    }
    case TeaserOptions::Selection::maximum_core:
      selected.rows = maximum_core(matrix);
      break;
    case TeaserOptions::Selection::everything:
      selected.rows.resize(matrix.size());
      std::iota(selected.rows.begin(), selected.rows.end(), 0U);
      break;
  }
  return selected;
}

/// The translation of q = R p + t by a vote on each axis; working frame. members: those in favour on all axes.
struct TranslationVote {
  std::array<double, 3> translation{};
  std::size_t members = 0;
};

TranslationVote vote_translation(const CorrespondenceView& view, std::span<const std::uint32_t> rows,
                                 const Eigen::Matrix3d& rotation, double noise_bound) {
  TranslationVote result;
  const std::vector<double> bounds(rows.size(), std::max(noise_bound * view.scale(), 1e-9));
  std::vector<double> values(rows.size());
  std::vector<int> votes(view.size(), 0);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::uint32_t k = rows[i];
      const Eigen::Vector3d source(view.source(0)[k], view.source(1)[k], view.source(2)[k]);
      values[i] = view.target(static_cast<std::size_t>(axis))[k] - rotation.row(axis).dot(source);
    }
    const AdaptiveVote vote = adaptive_voting(values, bounds);
    result.translation[static_cast<std::size_t>(axis)] = vote.value;
    for (const std::uint32_t i : vote.consensus) {
      if (++votes[rows[i]] == 3) ++result.members;
    }
  }
  return result;
}

}  // namespace

Registration register_teaser(const Correspondences& correspondences, const TeaserOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  Registration result = detail::start_registration(options.noise_bound, options.seed);
  const detail::StageClock clock(result.seconds);
  const CorrespondenceView view = correspondences.view();
  const std::size_t size = view.size();
  if (size < 3) {
    result.status = Status::too_few_correspondences;
    return result;
  }
  detail::require_matrix_budget(options.matrix_budget_bytes, size);

  StageReport selection_report{"maximum_clique", size};
  StageReport rotation_report{"gnc_rotation"};
  StageReport translation_report{"adaptive_voting"};
  StageReport refinement_report{"irls", size};
  Selected selected;
  {
    const detail::StageClock stage(selection_report.seconds);
    ConsistencyMatrix matrix;
    matrix.compute(view, result.consistency_bound);
    selected = select(matrix, options);
  }
  selection_report.output = rotation_report.input = translation_report.input = selected.rows.size();
  selection_report.iterations = selected.nodes;

  GncRotation rotation;
  {
    const detail::StageClock stage(rotation_report.seconds);
    rotation = gnc_rotation(correspondences, selected.rows,
                            {.difference_bound = result.consistency_bound, .pairs = options.rotation_pairs});
  }
  rotation_report.output = selected.rows.size();
  rotation_report.iterations = rotation.rounds;

  detail::BestPoses poses(correspondences, options.noise_bound);
  if (rotation.determined) {
    const detail::StageClock stage(translation_report.seconds);
    const TranslationVote vote = vote_translation(view, selected.rows, rotation.rotation, options.noise_bound);
    RigidTransform pose = RigidTransform::Identity();
    pose.linear() = rotation.rotation;
    pose.translation() = Eigen::Map<const Eigen::Vector3d>(vote.translation.data());
    detail::PoseCandidate candidate{to_working_pose(pose), {}};
    alignment_scores(view, std::span(&candidate.pose, 1), options.noise_bound, std::span(&candidate.support, 1));
    if (options.refine) candidate = detail::locally_optimise(correspondences, candidate, options.noise_bound);
    poses.offer(candidate);
    translation_report.output = vote.members;
    translation_report.iterations = 3;
  }

  // Tested as if the default search had found it from all of its seeds, which finds poses of chance at least as well.
  const TcfOptions test_options{
      .noise_bound = options.noise_bound, .seed = options.seed, .bounds_tried = options.bounds_tried};
  detail::FinalPose final;
  if (poses.best().support.count >= 3) {
    const detail::StageClock stage(refinement_report.seconds);
    final = detail::finish(correspondences, test_options, poses.best(), static_cast<std::uint32_t>(size),
                           options.refine ? detail::Refinement::full : detail::Refinement::none);
  }
  detail::conclude(correspondences, test_options, poses, selected.rows, final, selected.proven, result);
  refinement_report.output = result.inliers.size();
  refinement_report.iterations = final.rounds;
  result.stages = {selection_report, rotation_report, translation_report};
  if (options.refine) result.stages.push_back(refinement_report);
  return result;
}

}  // namespace consimd
