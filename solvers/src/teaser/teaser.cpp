#include <consimd/solvers/teaser.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/working_length.hpp>
#include <consimd/solvers/adaptive_voting.hpp>
#include <consimd/solvers/maximum_clique.hpp>

#include "scale/rival_scale.hpp"
#include "scale/scaled_registration.hpp"
#include "search/consensus_search.hpp"
#include "support/pose_candidate.hpp"
#include "teaser/teaser_options.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/final_pose.hpp"

namespace consimd {
namespace {

detail::Refinement refinement_of(const TeaserOptions& options) {
  return options.refine ? detail::Refinement::full : detail::Refinement::none;
}

/// The correspondences that TEASER estimates from.
struct Selected {
  std::vector<std::uint32_t> rows;
  bool proven = true;
  std::uint64_t nodes = 0;
  bool stopped = false;
};

Selected select(const ConsistencyMatrix& matrix, const TeaserOptions& options) {
  Selected selected;
  switch (options.selection) {
    case TeaserOptions::Selection::maximum_clique: {
      MaximumClique clique =
          maximum_clique(matrix, {.max_nodes = options.max_nodes, .max_work = options.max_work, .stop = options.stop});
      selected = {std::move(clique.members), clique.proven, clique.nodes, !clique.proven && options.stop.met()};
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
  const std::vector<double> bounds(rows.size(), working_length(view, noise_bound));
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

/// The pose of selected correspondences.
struct Estimate {
  detail::PoseCandidate candidate{};  ///< without support: the rotation is not determined
  std::uint32_t rotation_rounds = 0;
  std::size_t voters = 0;
  double rotation_seconds = 0.0;
  double translation_seconds = 0.0;
};

Estimate estimate(const Correspondences& correspondences, std::span<const std::uint32_t> rows,
                  const TeaserOptions& options) {
  Estimate result;
  GncRotation rotation;
  {
    const detail::StageClock clock(result.rotation_seconds);
    rotation = gnc_rotation(correspondences, rows,
                            {.difference_bound = 2.0 * options.noise_bound, .pairs = options.rotation_pairs});
  }
  result.rotation_rounds = rotation.rounds;
  if (!rotation.determined) return result;
  const detail::StageClock clock(result.translation_seconds);
  const CorrespondenceView view = correspondences.view();
  const TranslationVote vote = vote_translation(view, rows, rotation.rotation, options.noise_bound);
  result.voters = vote.members;
  RigidTransform pose = RigidTransform::Identity();
  pose.linear() = rotation.rotation;
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(vote.translation.data());
  result.candidate = detail::scored(view, to_working_pose(pose), options.noise_bound);
  if (options.refine) {
    result.candidate = detail::locally_optimise(correspondences, result.candidate, options.noise_bound);
  }
  return result;
}

// Part of the work of the first search that the one for a rival may take.
constexpr std::uint64_t kRivalWork = 4;

/// Offers the pose of a large clique of what the best pose does not explain, if that may be a rival. The greedy search
/// finds the cliques that stand out, as a motion's do; a proof would cost more than the pose itself. Returns whether
/// there is no such clique.
bool look_for_rival(const Correspondences& correspondences, const TeaserOptions& options, detail::BestPoses& poses) {
  std::vector<std::uint32_t> rest;
  for (std::uint32_t k = 0; k < correspondences.size(); ++k) {
    if (!poses.best_explains(k)) rest.push_back(k);
  }
  const auto supporters = static_cast<std::uint32_t>(std::ceil(detail::kRivalShare * poses.best().support.count));
  if (rest.size() < supporters) return true;
  const Correspondences others = correspondences.subset(rest);
  ConsistencyMatrix matrix;
  matrix.compute(others.view(), 2.0 * options.noise_bound);
  const MaximumClique clique = maximum_clique(matrix, {.max_nodes = 0,
                                                       .max_work = options.max_work / kRivalWork,
                                                       .larger_than = std::max(supporters, 3U) - 1,
                                                       .stop = options.stop});
  if (clique.members.empty()) return clique.proven;
  std::vector<std::uint32_t> rows;
  rows.reserve(clique.members.size());
  for (const std::uint32_t i : clique.members) rows.push_back(rest[i]);
  poses.offer(estimate(correspondences, rows, options).candidate);
  return false;
}

void solve(const Correspondences& correspondences, const TeaserOptions& options, Registration& result) {
  const std::size_t size = correspondences.size();
  StageReport selection_report{"maximum_clique", size};
  Selected selected;
  {
    const detail::StageClock stage(selection_report.seconds);
    ConsistencyMatrix matrix;
    matrix.compute(correspondences.view(), result.consistency_bound);
    selected = select(matrix, options);
  }
  selection_report.output = selected.rows.size();
  selection_report.iterations = selected.nodes;
  const Estimate best = estimate(correspondences, selected.rows, options);
  const std::size_t kept = selected.rows.size();
  result.stages = {selection_report,
                   {"gnc_rotation", kept, kept, best.rotation_rounds, best.rotation_seconds},
                   {"adaptive_voting", kept, best.voters, 3, best.translation_seconds}};

  detail::BestPoses poses(correspondences, options.noise_bound);
  bool confident = selected.proven;
  result.stopped = selected.stopped;
  if (best.candidate.support.count >= 3) {
    StageReport rival_report{"rival", size};
    {
      const detail::StageClock stage(rival_report.seconds);
      poses.offer(best.candidate);
      const bool without_rival = look_for_rival(correspondences, options, poses);
      result.stopped = result.stopped || (!without_rival && options.stop.met());
      confident = (confident || without_rival) && !result.stopped;
    }
    rival_report.output = poses.runner_up().support.count;
    result.stages.push_back(rival_report);
  }

  const detail::PoseTest test = {options.noise_bound, options.bounds_tried};
  detail::finish_and_conclude(correspondences, test, poses, selected.rows, confident, result, refinement_of(options));
}

Registration register_at_known_scale(const Correspondences& correspondences, const TeaserOptions& options) {
  return detail::run_at_known_scale(correspondences, options, solve);
}

}  // namespace

Registration register_teaser(const Correspondences& correspondences, const TeaserOptions& options) {
  detail::require_length("noise_bound", options.noise_bound);
  detail::require_options(detail::teaser_options(), options);
  detail::require_whole_matrix(options.matrix_budget_bytes, correspondences.size());
  if (!options.estimate_scale) return register_at_known_scale(correspondences, options);
  return detail::register_scaled(correspondences, {options.noise_bound, options.seed, options.threads},
                                 options.bounds_tried, refinement_of(options),
                                 [&](const Correspondences& scaled, std::uint32_t tried) {
                                   TeaserOptions known = options;
                                   known.bounds_tried = tried;
                                   known.threads = 0;
                                   return register_at_known_scale(scaled, known);
                                 });
}

}  // namespace consimd
