// What two clouds make of a registration of their correspondences.
#pragma once

#include <optional>

#include <consimd/features/pose_verification.hpp>
#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

struct CloudVerdict {
  /// How the clouds agree at the registration's pose, or at the one that the correspondences were too few for
  /// (Registration::refused); none where there is neither. Where the rival was taken for the pose, `runner_up` is of
  /// the pose that the correspondences gave; where the clouds have another pose that is as good, of that one.
  std::optional<PoseEvidence> pose = std::nullopt;
  std::optional<PoseEvidence> runner_up = std::nullopt;
  /// log10 of the chance of the pose that stands: that of the clouds' agreement times the number of such poses that the
  /// correspondences give by chance. 0 where none stands.
  double log10_of_both = 0.0;
  /// The pose is none that the correspondences gave, but one that the clouds led to from there.
  bool found_by_clouds = false;
  /// A pose that the clouds led to and all but bear out by themselves: another attempt, with other voxels, that leads
  /// to it as well is enough.
  std::optional<RigidTransform> led_to = std::nullopt;
  /// The status that the correspondences alone gave.
  Status of_correspondences = Status::no_consensus;
};

/// Whether clouds agree clearly better with one of them scaled: by a tenth.
[[nodiscard]] bool agrees_better_scaled(const PoseEvidence& evidence) noexcept;

/// Whether they do so by three hundredths or more, so that they cannot be of one scale: rows and surfaces of rooms may
/// fit within their bounds where one is a twentieth larger. Less is what sensors are off by.
[[nodiscard]] bool is_of_another_scale(const PoseEvidence& evidence) noexcept;

/// Whether the clouds cannot tell a pose from the rival that they have: it has four fifths of the pose's score, or half
/// of it and as many surfaces that agree, and is hardly more seen through; or it has half of the score and is seen
/// through nowhere, where displaced poses are: less of one scan is in sight of the other from a place that is further
/// away, but nothing speaks against it.
[[nodiscard]] bool has_equal_rival(const PoseEvidence& evidence) noexcept;

/// Whether the rival has four fifths of the pose's score and is not seen through. A pose that the correspondences
/// refuse is not taken where it has one.
[[nodiscard]] bool has_rival_in_doubt(const PoseEvidence& evidence) noexcept;

/// Whether clouds bear a pose out: it is seen through in few places, agrees better than chance gives and at one scale,
/// and the poses that correspondences give by chance (log10 of their number, as in Registration) times the chance that
/// one of these agrees as well is small. Where displaced poses hardly meet a surface that chance counts as 10^-4 at the
/// least.
[[nodiscard]] bool is_borne_out(const PoseEvidence& evidence, double log10_false_poses) noexcept;

/// Holds the pose and its rival against the clouds and lets these decide: a pose that they do not bear out becomes
/// `no_consensus`, of two that fit the correspondences alike the one that they bear out is the `success`, as is one
/// that had too few correspondences alone, if no rival of about its score is left in doubt. The pose is refined on the
/// correspondences where it was not theirs. A pose from which the clouds cannot tell another one of theirs is
/// `ambiguous`, with that one as the runner-up.
///
/// Where that leaves no pose, or one with an equal rival, the clouds lead on: the pose is fitted to the surfaces, and
/// its rival followed while that is the better one. What they lead to is the `success` where it is borne out, alone or
/// together with the correspondences, has no rival of about its score that is left in doubt, and three rows that
/// support it; it stays where the surfaces have it, with the rows that support it there and the covariance that the
/// correspondences give near it. Clouds without surfaces decide nothing. Adds the stage "verification": samples, those
/// that agree, poses tried.
///
/// `registration` is one of `correspondences`, whose rows are points of the verifier's clouds: poses are in the
/// caller's frames, its noise bound in the caller's unit. One without a pose and without a refused one stays as it is,
/// without the stage. `led_to_before`: CloudVerdict::led_to of another attempt. Throws std::invalid_argument on a pose,
/// this one too, that is not finite, or, where one was refused, has to be refined or a rival to be counted, on a noise
/// bound that is not above 0 and at most 1e307.
CloudVerdict decide(const PoseVerifier& verifier, const Correspondences& correspondences, Registration& registration,
                    const std::optional<RigidTransform>& led_to_before = std::nullopt);

}  // namespace features
}  // namespace consimd
