#include <consimd/features/cloud_verdict.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_refinement.hpp>
#include <consimd/solvers/significance.hpp>

namespace consimd::features {
namespace {

// log10 of the chance of the clouds' agreement, alone and times the number of poses that the correspondences give by
// chance. Of 377 poses between scans of different places, as the correspondences gave them, those that were seen
// through in few places had -6.6 of both at least, all but two -4; a street turned round has -7.9, right poses -8 to
// -60.
constexpr double kLeastChance = -2.5;
constexpr double kLeastOfBoth = -8.0;
// Share of the samples that tell for or against a pose, seen through: right poses have up to 0.02, those that are two
// voxels off 0.06, and half of those between different places 0.3 or more.
constexpr double kSeenThrough = 0.1;
// That share once the pose is fitted to the surfaces near it: right poses have up to 0.04, in rooms, and up to 0.012 in
// recorded scans; 3 wrong ones that were a success before had 0.06 to 0.09.
constexpr double kFittedSeenThrough = 0.05;

// Share of a pose's agreement, or of its score, from which on a rival is as good, as of correspondences.
constexpr double kRivalAgreement = 0.8;

// A rival that has less than this part of the share that displaced poses have is seen through nowhere: so have right
// poses. Beside the right poses of 40 synthetic rooms and streets the best rivals have 0.12 or more of it.
constexpr double kSeenNowhere = 0.05;
// A scan that is shifted by a house or a door has less of the other in its sight, but contradicts it nowhere, which
// tells something where displaced poses have a tenth seen through. Then this share of the pose's score is enough, as it
// is for a rival at which as many samples agree, if not the rare ones: screws turned end for end have 0.66 and 0.77.
constexpr double kLeastRivalScore = 0.5;
constexpr double kDisplacedAreSeenThrough = 0.1;

// Displaced poses that agree at less than this part of the samples hardly meet a surface, as of an object in an empty
// room. Their tail then says little of how rare an agreement is: it counts as what clouds alone have to show (kOnce),
// and without correspondences for nothing. Without this rule clouds alone bore out 69 right poses of 400 pairs, each
// with 0.041 of it or more, and nine wrong ones of others, of objects turned round, cropped scans and a building, of
// which seven have 0.025 or less.
constexpr double kDisplacedMeet = 0.03;
constexpr double kLeastChanceUnmet = -4.0;

// Gain of agreement by another scale of one cloud: up to 1.05 at right poses, 1.2 to 2.65 at those of rooms that are
// enlarged by a twentieth, whose rows are within the noise bound all the same. Scales nearer to 1 are no reason to
// refuse a pose: sensors and maps are off by a hundredth, and depth cameras' right poses fit best at 0.99 to 1.026.
constexpr double kGainOfScale = 1.1;
constexpr double kOtherScale = 0.03;

// Rivals that are better than the pose before them are followed at most so often: the search may go to and fro between
// two that each find the other better.
constexpr int kMostFollowed = 4;
// So many rows determine a pose.
constexpr std::size_t kLeastSupport = 3;

/// The part of what tells for or against a pose that is seen through.
double share_seen_through(double agreement, double seen_through) {
  return seen_through > 0.0 ? seen_through / (agreement + seen_through) : 0.0;
}

/// The part that is seen through of what tells for or against displaced poses.
double displaced_share_seen_through(const PoseEvidence& evidence) {
  return share_seen_through(evidence.displaced_agreement, evidence.displaced_seen_through);
}

bool is_seen_through(const PoseEvidence& evidence) {
  return share_seen_through(evidence.agreement, evidence.seen_through) > kSeenThrough ||
         share_seen_through(evidence.fitted_agreement, evidence.fitted_seen_through) > kFittedSeenThrough;
}

/// log10 of the chance of a pose's agreement, as far as displaced poses can tell it.
double counted_chance(const PoseEvidence& evidence) {
  const bool is_met = evidence.displaced_agreement >= kDisplacedMeet;
  return is_met ? evidence.log10_chance : std::max(evidence.log10_chance, kLeastChanceUnmet);
}

/// Rows within the noise bound, ascending.
std::vector<std::uint32_t> supporters(const Correspondences& correspondences, const WorkingPose& pose,
                                      double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  std::vector<std::uint64_t> bits(view.words());
  std::uint32_t count = 0;
  alignment_bits(view, std::span(&pose, 1), noise_bound, bits, std::span(&count, 1));
  std::vector<std::uint32_t> rows;
  rows.reserve(count);
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    if ((bits[row / 64] >> row % 64 & 1) != 0) rows.push_back(row);
  }
  return rows;
}

WorkingPose working_pose(const RigidTransform& T_target_source, const Correspondences& correspondences) {
  return to_working_pose(to_working_frame(T_target_source, correspondences));
}

/// The pose, or its rival, as the registration's result, refined on the correspondences.
void take(const RunnerUp& found, const Correspondences& correspondences, Registration& registration) {
  const RefinedPose refined =
      refine_pose(correspondences, working_pose(found.T_target_source, correspondences), {registration.noise_bound});
  registration.status = Status::success;
  registration.T_target_source = to_caller_frame(refined.fit.pose, correspondences);
  registration.covariance = refined.covariance;
  registration.log10_false_poses = found.log10_false_poses;
  registration.inliers = supporters(correspondences, to_working_pose(refined.fit.pose), registration.noise_bound);
}

/// A pose that the clouds gave, as the correspondences see it.
RunnerUp seen_by(const Correspondences& correspondences, const RigidTransform& T_target_source, double noise_bound) {
  const WorkingPose pose = working_pose(T_target_source, correspondences);
  return {T_target_source, supporters(correspondences, pose, noise_bound).size(),
          significance(correspondences, pose, noise_bound).log10_false_poses, 1.0};
}

void refuse(Registration& registration) {
  registration.status = Status::no_consensus;
  registration.refused = RunnerUp{registration.T_target_source, registration.inliers.size(),
                                  registration.log10_false_poses, registration.scale};
  registration.T_target_source = RigidTransform::Identity();
  registration.covariance = PoseCovariance::Zero();
  registration.inliers.clear();
  registration.runner_up.reset();
}

/// A pose that the clouds lead to, and what they tell of it.
struct Followed {
  RunnerUp found;
  PoseEvidence evidence;
  bool is_another = false;  // it is not alike the one that was followed from
};

/// From a pose, brought onto the surfaces near it, to its better rival, and from that to its own, until there is none.
Followed follow(const PoseVerifier& verifier, const Correspondences& correspondences, const RigidTransform& start,
                double noise_bound) {
  RigidTransform pose = verifier.fitted(start);
  PoseEvidence evidence = verifier.evidence(pose);
  for (int k = 0; k < kMostFollowed && evidence.rival && evidence.rival->share_of_score > 1.0; ++k) {
    pose = evidence.rival->T_target_source;
    evidence = verifier.evidence(pose);
  }
  return {seen_by(correspondences, pose, noise_bound), evidence, !verifier.are_alike(start, pose)};
}

/// What the clouds alone ask of a pose: log10 of its chance, and the share of its score that no other pose reaches.
struct AskedAlone {
  double log10_chance;
  double share_of_score;
};
// Of 1624 attempts at pairs of different places the clouds lead to no pose that is so rare with rivals so far below it;
// of 878 at pairs of one place, most of them far apart, to none that is wrong, and to 52 that are right and were none
// before. At -3.8 and -3.6, with 0.47, two are wrong.
constexpr AskedAlone kOnce{-4.0, 0.5};
// Two attempts with other voxels that lead to one pose need less. Of single attempts 1 and 3 are wrong by this, no two
// of one pair.
constexpr AskedAlone kTwice{-3.0, 0.6};

/// Whether the clouds alone bear a pose out, whatever the correspondences say: it is rarer than a pose has to be that
/// these bear out as well, the best of other poses has far less of its score, and it is seen through nowhere, where
/// displaced poses are. A pose without any rival has too little score for it, or the clouds are all but the same, which
/// correspondences tell.
bool is_borne_out_alone(const PoseEvidence& evidence, const AskedAlone& asked) {
  const double of_displaced = displaced_share_seen_through(evidence);
  return evidence.rival && evidence.rival->share_of_score < asked.share_of_score && !agrees_better_scaled(evidence) &&
         evidence.displaced_agreement >= kDisplacedMeet && evidence.log10_chance <= asked.log10_chance &&
         of_displaced >= kDisplacedAreSeenThrough &&
         share_seen_through(evidence.agreement, evidence.seen_through) <= kSeenNowhere * of_displaced;
}

/// Whether the clouds speak against a rival of a pose: it agrees less by more than what makes an ambiguous result, or
/// is seen through.
bool is_ruled_out(const PoseEvidence& rival, const PoseEvidence& pose) {
  return rival.agreement < kRivalAgreement * pose.agreement || is_seen_through(rival);
}

/// Lets the clouds decide on the pose that was found, its runner-up and the clouds' own rival of it.
void choose(const PoseVerifier& verifier, const Correspondences& correspondences, const RunnerUp& found,
            Registration& registration, CloudVerdict& verdict) {
  const bool has_pose = registration.has_pose();
  // A pose that the correspondences refuse is none where the clouds leave it in doubt as well.
  const bool stands =
      is_borne_out(*verdict.pose, found.log10_false_poses) && (has_pose || !has_rival_in_doubt(*verdict.pose));
  bool runner_up_stands = false;
  if (has_pose && registration.runner_up) {
    verdict.runner_up = verifier.evidence(registration.runner_up->T_target_source);
    runner_up_stands = is_borne_out(*verdict.runner_up, registration.runner_up->log10_false_poses);
  }
  if (stands) verdict.log10_of_both = counted_chance(*verdict.pose) + found.log10_false_poses;
  if (!has_pose && stands) {
    take(found, correspondences, registration);
    registration.refused.reset();
  } else if (has_pose && !stands && runner_up_stands) {
    const RunnerUp other = *registration.runner_up;
    verdict.log10_of_both = counted_chance(*verdict.runner_up) + other.log10_false_poses;
    take(other, correspondences, registration);
    registration.runner_up.reset();
    std::swap(verdict.pose, verdict.runner_up);  // what the verdict tells is of the pose that is taken
  } else if (has_pose && !stands) {
    refuse(registration);
  } else if (registration.status == Status::ambiguous && !runner_up_stands &&
             is_ruled_out(*verdict.runner_up, *verdict.pose)) {
    registration.status = Status::success;
    registration.runner_up.reset();
  }
  if (registration.status == Status::success && has_equal_rival(*verdict.pose)) {
    const RivalPose& rival = *verdict.pose->rival;
    const RunnerUp runner_up = seen_by(correspondences, rival.T_target_source, registration.noise_bound);
    verdict.runner_up = verifier.evidence(rival.T_target_source);
    registration.runner_up = runner_up;
    registration.status = Status::ambiguous;
  }
}

/// The pose that the clouds led to, as the registration's result, where they or both bear it out.
void take_if_borne_out(const Followed& followed, const PoseVerifier& verifier, const Correspondences& correspondences,
                       const std::optional<RigidTransform>& led_to_before, Registration& registration,
                       CloudVerdict& verdict) {
  const RunnerUp& other = followed.found;
  const PoseEvidence& evidence = followed.evidence;
  if (has_equal_rival(evidence) || has_rival_in_doubt(evidence) || other.support < kLeastSupport) return;
  const bool is_met_again = led_to_before && verifier.are_alike(*led_to_before, other.T_target_source);
  if (!is_borne_out(evidence, other.log10_false_poses) &&
      !is_borne_out_alone(evidence, is_met_again ? kTwice : kOnce)) {
    if (is_borne_out_alone(evidence, kTwice)) verdict.led_to = other.T_target_source;
    return;
  }
  take(other, correspondences, registration);
  registration.T_target_source = other.T_target_source;
  registration.inliers =
      supporters(correspondences, working_pose(other.T_target_source, correspondences), registration.noise_bound);
  registration.refused.reset();
  registration.runner_up.reset();
  verdict.runner_up = std::exchange(verdict.pose, evidence);
  // Correspondences that speak against it do not count against clouds that bear it out alone.
  verdict.log10_of_both = counted_chance(evidence) + std::min(other.log10_false_poses, 0.0);
  verdict.found_by_clouds = true;
}

}  // namespace

bool agrees_better_scaled(const PoseEvidence& evidence) noexcept { return evidence.scaled.gain >= kGainOfScale; }

bool is_of_another_scale(const PoseEvidence& evidence) noexcept {
  return agrees_better_scaled(evidence) && std::abs(evidence.scaled.scale - 1.0) >= kOtherScale;
}

bool has_equal_rival(const PoseEvidence& evidence) noexcept {
  if (!evidence.rival) return false;
  const RivalPose& rival = *evidence.rival;
  const double of_pose = share_seen_through(evidence.agreement, evidence.seen_through);
  const double of_rival = share_seen_through(rival.agreement, rival.seen_through);
  const double of_displaced = displaced_share_seen_through(evidence);
  const bool is_clean = of_rival <= kSeenNowhere * of_displaced;
  // A pose that is itself seen through does not rule a rival out by that.
  const bool is_not_ruled_out = is_clean || of_rival <= 2.0 * of_pose;
  if (rival.share_of_score >= kRivalAgreement) return is_not_ruled_out;
  if (rival.share_of_score < kLeastRivalScore) return false;
  return (rival.share_of_agreement >= 1.0 && is_not_ruled_out) ||
         (is_clean && of_displaced >= kDisplacedAreSeenThrough);
}

bool has_rival_in_doubt(const PoseEvidence& evidence) noexcept {
  return evidence.rival && evidence.rival->share_of_score >= kRivalAgreement &&
         share_seen_through(evidence.rival->agreement, evidence.rival->seen_through) <= kSeenThrough;
}

bool is_borne_out(const PoseEvidence& evidence, double log10_false_poses) noexcept {
  const double log10_chance = counted_chance(evidence);
  return evidence.samples > 0 && !is_seen_through(evidence) && !is_of_another_scale(evidence) &&
         log10_chance <= kLeastChance && log10_chance + log10_false_poses <= kLeastOfBoth;
}

CloudVerdict decide(const PoseVerifier& verifier, const Correspondences& correspondences, Registration& registration,
                    const std::optional<RigidTransform>& led_to_before) {
  if (led_to_before && !led_to_before->matrix().allFinite()) {
    throw std::invalid_argument("led_to_before is not finite");
  }
  CloudVerdict verdict;
  verdict.of_correspondences = registration.status;
  const bool has_pose = registration.has_pose();
  if (!has_pose && !registration.refused) return verdict;

  const auto start = std::chrono::steady_clock::now();
  // What else the data give to motions like a refused pose is for the clouds to tell, which have rivals of their own.
  const RunnerUp found =
      has_pose ? RunnerUp{registration.T_target_source, registration.inliers.size(), registration.log10_false_poses,
                          registration.scale}
               : seen_by(correspondences, registration.refused->T_target_source, registration.noise_bound);
  verdict.pose = verifier.evidence(found.T_target_source);
  if (verdict.pose->samples > 0) {
    choose(verifier, correspondences, found, registration, verdict);
    const bool is_one_of_two = registration.status == Status::ambiguous && has_equal_rival(*verdict.pose);
    if (!registration.has_pose() || is_one_of_two) {
      const RigidTransform& from = registration.has_pose() ? registration.T_target_source : found.T_target_source;
      const Followed followed = follow(verifier, correspondences, from, registration.noise_bound);
      if (followed.is_another || !is_one_of_two) {
        take_if_borne_out(followed, verifier, correspondences, led_to_before, registration, verdict);
      }
    }
  }
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const auto samples = static_cast<double>(verdict.pose->samples);
  registration.stages.push_back({"verification", verdict.pose->samples,
                                 static_cast<std::size_t>(std::lround(verdict.pose->agreement * samples)),
                                 verdict.pose->displacements, taken.count()});
  registration.seconds += taken.count();
  return verdict;
}

}  // namespace consimd::features
