#include <consimd/features/cloud_verdict.hpp>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/poses/rigid_fit.hpp>
#include <consimd/solvers/pose_refinement.hpp>

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

// Share of a pose's agreement from which on a rival is as good, as of correspondences.
constexpr double kRivalAgreement = 0.8;

bool is_seen_through(const PoseEvidence& evidence) {
  return evidence.seen_through > kSeenThrough * (evidence.agreement + evidence.seen_through);
}

/// The pose, or its rival, as the registration's result.
void take(const RunnerUp& found, const Correspondences& correspondences, Registration& registration) {
  const RefinedPose refined =
      refine_pose(correspondences, to_working_pose(to_working_frame(found.T_target_source, correspondences)),
                  {registration.noise_bound});
  const WorkingPose pose = to_working_pose(refined.fit.pose);
  const CorrespondenceView view = correspondences.view();
  std::vector<std::uint64_t> bits(view.words());
  std::uint32_t count = 0;
  alignment_bits(view, std::span(&pose, 1), registration.noise_bound, bits, std::span(&count, 1));
  std::vector<std::uint32_t> inliers;
  inliers.reserve(count);
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    if ((bits[row / 64] >> row % 64 & 1) != 0) inliers.push_back(row);
  }
  registration.status = Status::success;
  registration.T_target_source = to_caller_frame(refined.fit.pose, correspondences);
  registration.covariance = refined.covariance;
  registration.log10_false_poses = found.log10_false_poses;
  registration.inliers = std::move(inliers);
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

/// Whether the clouds speak against a rival of a pose: it agrees less by more than what makes an ambiguous result, or
/// is seen through.
bool is_ruled_out(const PoseEvidence& rival, const PoseEvidence& pose) {
  return rival.agreement < kRivalAgreement * pose.agreement || is_seen_through(rival);
}

}  // namespace

bool is_borne_out(const PoseEvidence& evidence, double log10_false_poses) noexcept {
  return evidence.samples > 0 && !is_seen_through(evidence) && evidence.log10_chance <= kLeastChance &&
         evidence.log10_chance + log10_false_poses <= kLeastOfBoth;
}

CloudVerdict decide(const PoseVerifier& verifier, const Correspondences& correspondences, Registration& registration) {
  CloudVerdict verdict;
  verdict.of_correspondences = registration.status;
  const bool has_pose = registration.has_pose();
  if (!has_pose && !registration.refused) return verdict;

  const auto start = std::chrono::steady_clock::now();
  const RunnerUp found = has_pose ? RunnerUp{registration.T_target_source, registration.inliers.size(),
                                             registration.log10_false_poses, registration.scale}
                                  : *registration.refused;
  verdict.pose = verifier.evidence(found.T_target_source);
  const bool stands = is_borne_out(*verdict.pose, found.log10_false_poses);
  bool rival_stands = false;
  if (has_pose && registration.runner_up) {
    verdict.runner_up = verifier.evidence(registration.runner_up->T_target_source);
    rival_stands = is_borne_out(*verdict.runner_up, registration.runner_up->log10_false_poses);
  }
  if (verdict.pose->samples > 0) {
    if (stands) verdict.log10_of_both = verdict.pose->log10_chance + found.log10_false_poses;
    if (!has_pose && stands) {
      take(found, correspondences, registration);
      registration.refused.reset();
    } else if (has_pose && !stands && rival_stands) {
      const RunnerUp rival = *registration.runner_up;
      verdict.log10_of_both = verdict.runner_up->log10_chance + rival.log10_false_poses;
      take(rival, correspondences, registration);
      registration.runner_up.reset();
      std::swap(verdict.pose, verdict.runner_up);  // what the verdict tells is of the pose that is taken
    } else if (has_pose && !stands) {
      refuse(registration);
    } else if (registration.status == Status::ambiguous && !rival_stands &&
               is_ruled_out(*verdict.runner_up, *verdict.pose)) {
      registration.status = Status::success;
      registration.runner_up.reset();
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
