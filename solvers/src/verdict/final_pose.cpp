#include "verdict/final_pose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <consimd/kernels/elementary_functions.hpp>
#include <consimd/solvers/pose_refinement.hpp>

#include "call/stage_clock.hpp"
#include "verdict/ambiguity.hpp"
#include "verdict/another_scale.hpp"
#include "verdict/false_poses.hpp"
#include "verdict/mirror_image.hpp"
#include "verdict/pose_checks.hpp"
#include "verdict/shifted_motion.hpp"
#include "verdict/turned_motion.hpp"

namespace consimd::detail {
namespace {

// The deviation of a residual per axis, where it is not estimated: the noise bound is three of them.
constexpr double kSigmaPerBound = 1.0 / 3.0;

// log10 of false poses down to which repeated structure is looked for: three times what success needs. A shift with
// less than half of the support does not repeat the pose.
constexpr double kRepeatable = 3.0 * kSignificant;
constexpr double kRepeatedShare = 0.5;

// Shifts that are as well supported by chance once in so many times show no repeated structure. What they reach is the
// median of so many of the best.
constexpr double kChanceMotions = 0.01;
constexpr std::size_t kBestMotions = 8;
constexpr std::uint32_t kMotionPairings = 32;  // of all rows, which tell that chance

// Where a pose is looked at: two tries at being significant.
constexpr double kPlaces = 2.0;

// A close look at a pose that a glance leaves in doubt.
double significance_if_doubtful(const Correspondences& correspondences, const PoseTest& test, const WorkingPose& pose) {
  const Significance glance = significance(correspondences, pose, test.noise_bound, Scrutiny::glance);
  if (glance.log10_false_poses < kBeyondDoubt) return glance.log10_false_poses;
  return test.log10_false_poses(correspondences, pose);
}

// The runner-up, brought into place like the best pose was; none if it is no other motion then.
std::optional<RunnerUp> runner_up(const Correspondences& correspondences, const PoseTest& test,
                                  const BestPoses& poses) {
  if (poses.runner_up().support.count < 3) return std::nullopt;
  const PoseCandidate rival = locally_optimise(correspondences, poses.runner_up(), test.noise_bound);
  if (poses.same_motion_as_best(rival.pose)) return std::nullopt;
  const double log10_false_poses =
      is_rival(rival.support.count, poses.best().support.count)
          ? significance_if_doubtful(correspondences, test, rival.pose)
          : significance(correspondences, rival.pose, test.noise_bound, Scrutiny::glance).log10_false_poses;
  return RunnerUp{to_caller_frame(from_working_pose(rival.pose), correspondences), rival.support.count,
                  log10_false_poses};
}

// An estimate that nothing refined may have a part of the consensus, which makes it significant, and leave the rest.
// The pose near it that has so many more supporters that the estimate is no rival of it, if there is one.
std::optional<RunnerUp> better_pose_near(const Correspondences& correspondences, const PoseTest& test,
                                         const BestPoses& poses) {
  const PoseCandidate found = widely_optimise(correspondences, poses.best(), test.noise_bound);
  if (is_rival(poses.best().support.count, found.support.count)) return std::nullopt;
  return RunnerUp{to_caller_frame(from_working_pose(found.pose), correspondences), found.support.count,
                  significance_if_doubtful(correspondences, test, found.pose)};
}

// log10 by which the best pose is more significant than another motion: what that reaches in the same data, structure
// reaches that no stratum knows of. A motion whose supporters are mostly those of the best pose tells nothing.
double lead(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses,
            const WorkingPose& other) {
  const std::vector<std::uint32_t> rows = pose_inliers(correspondences.view(), other, test.noise_bound);
  const auto shared = std::ranges::count_if(rows, [&](std::uint32_t row) { return poses.best_explains(row); });
  const double of_best = test.log10_false_poses(correspondences, poses.best().pose);
  if (2 * static_cast<std::size_t>(shared) > rows.size()) return of_best;
  return of_best - std::min(0.0, test.log10_false_poses(correspondences, other));
}

// log10 of the chance that another motion, of those that repeat the best pose, is supported as well as it: where
// windows repeat every pose on them has some support, as every turn about a sensor has on its rings, and only what
// stands out against that tells of a motion. It is asked where the best of them has more than chance and strata give;
// and where they are many that have more than random pairing gives them, as windows in two rows each make them, which
// no stratum sees. These are held against the pose by their median: the best ones about a true pose share some of its
// support.
double lead_over(const RepeatedMotions& others, const Correspondences& correspondences, const PoseTest& test,
                 const BestPoses& poses) {
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const CorrespondenceView view = correspondences.view();
  const auto size = static_cast<double>(view.size());
  double reached = 0.0;
  if (test.log10_false_poses(correspondences, others.best.pose) < 0.0) {
    reached = independent_support(view, others.best.pose, test.noise_bound);
  } else {
    const MatchedPoints matched(view, others.best.pose, test.noise_bound);
    const std::array bounds{test.noise_bound};
    const double chance =
        pose_chances(view, others.best.pose, bounds, kMotionPairings, RareHits::extrapolated, matched).front();
    if (log_chance_of(others, size, chance) >= elementary::log(kChanceMotions)) return kNone;
    reached = others.independent[std::min(others.independent.size(), kBestMotions) / 2];
  }
  const double supporters = independent_support(view, poses.best().pose, test.noise_bound);
  return log_binomial_tail(size, supporters, reached / size) / std::numbers::ln10;
}

// The largest lead over shifts, one of which has half of the support of the best pose, and turns about the viewpoint.
double lead_over_repetitions(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses) {
  double lead = -std::numeric_limits<double>::infinity();
  const RepeatedMotions shifts = shifted_motions(correspondences, poses, test.noise_bound);
  const auto needed = kRepeatedShare * static_cast<double>(poses.best().support.count);
  const bool repeats = shifts.best.support.count >= 3 && static_cast<double>(shifts.best.support.count) >= needed &&
                       !poses.same_motion_as_best(shifts.best.pose);
  // Asked late: a glance may have told the pose, and a close look takes longer than all shifts.
  if (repeats && test.log10_false_poses(correspondences, poses.best().pose) >= kRepeatable) {
    lead = lead_over(shifts, correspondences, test, poses);
  }
  if (lead >= kSignificant || test.log10_false_poses(correspondences, poses.best().pose) < kRepeatable) return lead;
  const RepeatedMotions turns = turned_motions(correspondences, poses, test.noise_bound);
  return turns.independent.empty() ? lead : std::max(lead, lead_over(turns, correspondences, test, poses));
}

RunnerUp refused_pose(const Correspondences& correspondences, const FinalPose& final, const Registration& result) {
  return {to_caller_frame(final.pose, correspondences), final.inliers.size(), result.log10_false_poses};
}

// Rows that agree in length with three of the supporters.
std::vector<std::uint32_t> agreeing_rows(const Correspondences& correspondences, const FinalPose& final,
                                         const PoseTest& test) {
  const std::vector<std::uint32_t>& rows = final.inliers;
  return rows_agreeing_with(correspondences, {rows.front(), rows[rows.size() / 2], rows.back()}, test.noise_bound);
}

// The pose that is most likely near one. Which pose has the largest score about it depends on the way there, and rows
// at the rim, which decide over a dozen places, come and go; likelihood has one maximum.
PoseCandidate most_likely(const Correspondences& correspondences, const PoseCandidate& start, double noise_bound) {
  const RigidFit fit = refine_pose(correspondences, start.pose, {noise_bound}).fit;
  if (!fit.determined()) return start;
  const PoseCandidate found = scored(correspondences.view(), to_working_pose(fit.pose), noise_bound);
  return found.support.count < 3 ? start : found;
}

// Brings the best pose and the runner-up into place and lets the more significant of them be the best pose, which
// `log10_false_poses` is told of. Returns whether it was the runner-up.
bool most_significant(const Correspondences& correspondences, const PoseTest& test, Refinement refinement,
                      BestPoses& poses, double& log10_false_poses) {
  const double noise_bound = test.noise_bound;
  const bool moves = refinement == Refinement::full;
  if (moves) poses.promote(widely_optimise(correspondences, poses.best(), noise_bound));
  log10_false_poses = significance(correspondences, poses.best().pose, noise_bound, Scrutiny::glance).log10_false_poses;
  if (log10_false_poses < kBeyondDoubt) return false;
  const PoseCandidate best = poses.best();
  if (moves) poses.promote(most_likely(correspondences, best, noise_bound));
  log10_false_poses = test.log10_false_poses(correspondences, poses.best().pose);
  if (moves && log10_false_poses >= kSignificant) {
    // Half a dozen supporters hardly tell their noise, and so not where they make the pose most likely.
    const double of_best =
        test.log10_false_poses(correspondences, best.pose, kSignificant) + elementary::log10(kPlaces);
    if (of_best < kSignificant) {
      log10_false_poses = of_best;
      poses.promote(best);
    }
  }
  if (log10_false_poses < kBeyondDoubt || poses.runner_up().support.count < 3) return false;
  PoseCandidate rival = widely_optimise(correspondences, poses.runner_up(), noise_bound);
  if (moves) rival = most_likely(correspondences, rival, noise_bound);
  if (poses.same_motion_as_best(rival.pose)) return false;
  const double of_rival = test.log10_false_poses(correspondences, rival.pose);
  if (of_rival >= log10_false_poses) return false;
  log10_false_poses = of_rival;
  poses.promote(rival);
  return true;
}

// Whether the supporters, or all rows where there are none, leave a part of the pose free. What looks like a rotation
// that is told is looked at closely where chance gives no such pose.
bool is_degenerate(const Correspondences& correspondences, const PoseTest& test, const FinalPose& final) {
  if (final.inliers.size() < 3) return coincident_or_collinear(correspondences);
  return final.rotation_deviation > kLargestRotationDeviation ||
         (final.log10_false_poses < kSignificant &&
          leaves_a_rotation_free(correspondences.view(), final.inliers, test.noise_bound, final.sigma));
}

}  // namespace

FinalPose finish(const Correspondences& correspondences, const PoseTest& test, BestPoses& poses, Refinement refinement,
                 const std::optional<Significance>& glance) {
  const CorrespondenceView view = correspondences.view();
  const double tau = test.noise_bound;
  FinalPose final;
  double false_poses = 0.0;
  if (glance) {
    false_poses = glance->log10_false_poses;
  } else {
    final.was_runner_up = most_significant(correspondences, test, refinement, poses, false_poses);
  }
  const PoseCandidate& best = poses.best();
  RefinedPose refined;
  if (refinement == Refinement::full) {
    refined = refine_pose(correspondences, best.pose, {tau});
  } else {
    refined.fit.pose = from_working_pose(best.pose);
    refined.sigma = kSigmaPerBound * tau;
  }
  WorkingPose pose = to_working_pose(refined.fit.pose);
  final.inliers = pose_inliers(view, pose, tau);
  if (final.inliers.size() < 3) {
    // The weights moved it off its supporters.
    pose = best.pose;
    refined.fit.pose = from_working_pose(pose);
    final.inliers = pose_inliers(view, pose, tau);
  }
  final.pose = refined.fit.pose;
  final.rounds = refined.rounds;
  final.covariance = refined.covariance;
  final.scale = refined.scale;
  final.scale_deviation = refined.scale_deviation;
  final.shared_errors = refined.shared_errors;
  final.centre = refined.centre;
  final.sigma = refined.sigma;
  final.rotation_deviation = rotation_deviation(view, pose, tau, refined.sigma);
  final.log10_false_poses = false_poses + elementary::log10(std::max(test.bounds_tried, 1U));
  return final;
}

void conclude(const Correspondences& correspondences, const PoseTest& test, const BestPoses& poses,
              const std::vector<std::uint32_t>& set, const FinalPose& final, bool confident, Registration& result) {
  result.log10_false_poses = final.log10_false_poses;
  const bool supported = final.inliers.size() >= 3;
  const std::vector<std::uint32_t> agreeing =
      supported && final.was_runner_up ? agreeing_rows(correspondences, final, test) : set;
  if (is_degenerate(correspondences, test, final)) {
    result.status = Status::degenerate_geometry;
  } else if (const MirroredSupport image = mirrored_support(correspondences, agreeing, test.noise_bound);
             is_mirrored(image, final.inliers.size())) {
    result.status = Status::no_consensus;
    result.mirrored = is_mirror_image(image, agreeing.size(), correspondences.size());
  } else if (!supported || final.log10_false_poses >= kSignificant) {
    result.status = Status::no_consensus;
    if (supported) result.refused = refused_pose(correspondences, final, result);
  } else if (is_at_another_scale(correspondences, test, final)) {
    result.status = Status::no_consensus;
  } else if (is_part_of_a_mirror_image(correspondences, final.inliers, test.noise_bound)) {
    result.status = Status::no_consensus;
    result.mirrored = true;
  } else {
    std::optional<RunnerUp> rival = runner_up(correspondences, test, poses);
    const bool as_good = rival && is_rival(rival->support, poses.best().support.count);
    bool ambiguous = as_good && rival->log10_false_poses < kSignificantRival;
    if (rival && !ambiguous && rival->log10_false_poses < 0.0) {
      const WorkingPose other = to_working_pose(to_working_frame(rival->T_target_source, correspondences));
      const double ahead = lead(correspondences, test, poses, other);
      // One that would be a success itself is told of, not held against the best pose.
      ambiguous = as_good && rival->log10_false_poses < kSignificant && ahead >= kSignificant;
      if (!ambiguous) result.log10_false_poses = std::max(result.log10_false_poses, ahead);
    }
    if (!ambiguous && final.log10_false_poses > kRepeatable) {
      result.log10_false_poses =
          std::max(result.log10_false_poses, lead_over_repetitions(correspondences, test, poses));
    }
    if (result.log10_false_poses >= kSignificant) {
      result.status = Status::no_consensus;
      result.refused = refused_pose(correspondences, final, result);
      return;
    }
    // One that chance gives as well tells nobody anything.
    if (rival && rival->log10_false_poses < kSignificant) result.runner_up = std::move(rival);
    result.status = ambiguous ? Status::ambiguous : confident ? Status::success : Status::budget_exhausted;
    result.T_target_source = to_caller_frame(final.pose, correspondences);
    result.covariance = final.covariance;
    result.inliers = final.inliers;
  }
}

void finish_and_conclude(const Correspondences& correspondences, const PoseTest& test, BestPoses poses,
                         const std::vector<std::uint32_t>& set, bool confident, Registration& result,
                         Refinement refinement) {
  const std::size_t size = correspondences.size();
  StageReport report{refinement == Refinement::full ? "refinement" : "significance", size};
  FinalPose final;
  if (poses.best().support.count >= 3) {
    const StageClock clock(report.seconds);
    final = finish(correspondences, test, poses, refinement);
  }
  conclude(correspondences, test, poses, set, final, confident, result);
  if (refinement == Refinement::none && result.has_pose() && result.status != Status::ambiguous) {
    if (const auto better = better_pose_near(correspondences, test, poses)) {
      result.status = Status::ambiguous;
      result.runner_up = better;
    }
  }
  report.output = result.inliers.size();
  report.iterations = final.rounds;
  result.stages.push_back(report);
}

}  // namespace consimd::detail
