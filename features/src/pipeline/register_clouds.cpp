#include <consimd/features/register_clouds.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <utility>

#include <consimd/solvers/threads.hpp>

#include "pipeline/voxel_choice.hpp"

namespace consimd::features {
namespace {

// Coarser voxels give fewer and larger surfaces: scans that are far apart have more of these in common.
constexpr double kCoarser = 1.5;
// A pose whose chance is larger is held against what the coarser voxels give: the right ones that clouds and
// correspondences leave in doubt are often beyond it there.
constexpr double kBeyondDoubt = -12.0;
// Two attempts find 32 of eighty made-up places that are seen from two points, most of them 12 to 28 m apart; three
// find 49, four 52 and five 53.
constexpr std::uint32_t kMostAttempts = 4;
// Points a voxel, of the attempts after the first one: scans of 16 beams, or thinned out along their rings, have
// surfaces from then on: of twelve streets scanned so 1 is found at first, 5 with four points and 11 with eight; of
// fourteen objects of 2000 points all at first, 13 with four and 2 with eight.
constexpr std::array kPointsAcrossRings{4.0, 8.0};
constexpr std::size_t kFewVoxels = 64;

/// led_to: by an attempt before this one, see CloudVerdict.
CloudRegistration attempt(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options,
                          const std::optional<RigidTransform>& led_to = std::nullopt) {
  CloudRegistration result{match_clouds(source, target, options.matching), {}};
  result.registration = register_by_name(options.solver, result.matches.correspondences,
                                         {.noise_bound = options.noise_bound.value_or(result.matches.noise_bound),
                                          .seed = options.seed,
                                          .filter = options.filter,
                                          .stop = options.stop});
  if (options.verify) {
    result.verdict = verify_registration(source, target, result.matches, options.matching, result.registration, led_to);
  }
  return result;
}

/// Whether an attempt has shown what coarser voxels can only forget: that the scene repeats itself, or that the clouds
/// are not of one scale.
bool is_decided(const CloudRegistration& found) {
  if (!found.verdict->pose) return false;
  const PoseEvidence& evidence = *found.verdict->pose;
  if (const auto& refused = found.registration.refused; refused && is_of_another_scale(evidence)) {
    PoseEvidence at_any_scale = evidence;
    at_any_scale.scaled = {};
    return is_borne_out(at_any_scale, refused->log10_false_poses);
  }
  return found.registration.status == Status::ambiguous && has_equal_rival(evidence);
}

/// The voxel of another attempt, coarser than that of the last one. attempts: made so far.
double coarser_than(double voxel, const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options,
                    std::uint32_t attempts) {
  const double coarser = kCoarser * voxel;
  if (options.matching.voxel || attempts > kPointsAcrossRings.size()) return coarser;
  const double points_a_voxel = kPointsAcrossRings[attempts - 1];
  return std::max({coarser, detail::voxel_across_rings(source, points_a_voxel),
                   detail::voxel_across_rings(target, points_a_voxel)});
}

/// The best of up to kMostAttempts. A pose that coarser voxels give is refined on these: as it is it may be off by a
/// part of them that the first ones would not be.
CloudRegistration verified(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options) {
  CloudRegistration best = attempt(source, target, options);
  if (!options.verify) return best;
  const double first = best.matches.voxel;
  double voxel = first;
  double needed = kBeyondDoubt;
  std::optional<RigidTransform> led_to = best.verdict->led_to;
  bool decided = is_decided(best);
  std::size_t voxels = std::min(best.matches.source.voxels, best.matches.target.voxels);
  for (std::uint32_t attempts = 1; attempts < kMostAttempts; ++attempts) {
    if (best.verdict->log10_of_both < needed || best.registration.stopped || decided) break;
    // Clouds of a few voxels would be left with none.
    if (voxels < kFewVoxels) break;
    voxel = coarser_than(voxel, source, target, options, attempts);
    CloudRegistrationOptions another = options;
    another.matching.voxel = voxel;
    CloudRegistration found = attempt(source, target, another, led_to);
    if (found.verdict->led_to) led_to = found.verdict->led_to;
    decided = is_decided(found);
    voxels = std::min(found.matches.source.voxels, found.matches.target.voxels);
    const bool stopped = found.registration.stopped;
    const bool tells_more = decided && best.verdict->log10_of_both >= 0.0;
    if (tells_more || found.verdict->log10_of_both < best.verdict->log10_of_both) best = std::move(found);
    best.registration.stopped = best.registration.stopped || stopped;
    best.attempts = attempts + 1;
    needed = 0.0;
  }
  const bool is_coarse = best.matches.voxel > first && !best.verdict->found_by_clouds;
  if (is_coarse && best.registration.has_pose() && !options.refine) {
    refine_registration(best.matches, RefinementMethod::plane, best.registration);
  }
  return best;
}

}  // namespace

CloudVerdict verify_registration(const Cloud& source, const Cloud& target, const CloudMatches& matches,
                                 const CloudMatchingOptions& options, Registration& registration,
                                 const std::optional<RigidTransform>& led_to_before) {
  if (!registration.has_pose() && !registration.refused) return {.of_correspondences = registration.status};
  const auto start = std::chrono::steady_clock::now();
  const PoseVerifier verifier({source, *matches.source_voxels, options.source_viewpoint},
                              {target, *matches.target_voxels, options.target_viewpoint}, matches.voxel, options.seed);
  const std::chrono::duration<double> prepared = std::chrono::steady_clock::now() - start;
  const CloudVerdict verdict = decide(verifier, matches.correspondences, registration, led_to_before);
  registration.stages.back().seconds += prepared.count();
  registration.seconds += prepared.count();
  if (verdict.found_by_clouds) refine_registration(matches, RefinementMethod::plane, registration);
  return verdict;
}

Refinement refine_registration(const CloudMatches& matches, RefinementMethod method, Registration& registration) {
  Refinement refined =
      refine(matches.source_voxels->cloud(), matches.target_voxels->cloud(), registration.T_target_source,
             {.method = method, .max_distance = registration.noise_bound});
  if (refined.has_pose()) {
    registration.T_target_source = refined.T_target_source;
    registration.covariance = refined.covariance;
  }
  registration.stages.push_back(
      {"refine", matches.source_voxels->size(), refined.pairs, refined.iterations, refined.seconds});
  registration.seconds += refined.seconds;
  return refined;
}

CloudRegistration register_clouds(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options) {
  CloudRegistration result;
  run_on_threads(options.threads, [&] {
    result = verified(source, target, options);
    if (options.refine && result.registration.has_pose()) {
      result.refinement = refine_registration(result.matches, *options.refine, result.registration);
    }
  });
  return result;
}

}  // namespace consimd::features
