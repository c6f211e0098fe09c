#include <consimd/features/register_clouds.hpp>

#include <algorithm>
#include <chrono>
#include <utility>

#include <consimd/solvers/threads.hpp>

namespace consimd::features {
namespace {

// Coarser voxels give fewer and larger surfaces: scans that are far apart have more of these in common.
constexpr double kCoarser = 1.5;
// A pose whose chance is larger is held against what the coarser voxels give: the right ones that clouds and
// correspondences leave in doubt are often beyond it there.
constexpr double kBeyondDoubt = -12.0;

CloudRegistration attempt(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options) {
  CloudRegistration result{match_clouds(source, target, options.matching), {}};
  result.registration = register_by_name(options.solver, result.matches.correspondences,
                                         {.noise_bound = options.noise_bound.value_or(result.matches.noise_bound),
                                          .seed = options.seed,
                                          .filter = options.filter,
                                          .stop = options.stop});
  if (options.verify) {
    result.verdict = verify_registration(source, target, result.matches, options.matching, result.registration);
  }
  return result;
}

/// The better of one or two attempts.
CloudRegistration verified(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options) {
  CloudRegistration first = attempt(source, target, options);
  if (!options.verify || first.verdict->log10_of_both < kBeyondDoubt || first.registration.stopped) return first;
  // Clouds of a few voxels would be left with none.
  constexpr std::size_t kFewVoxels = 64;
  if (std::min(first.matches.source.voxels, first.matches.target.voxels) < kFewVoxels) return first;
  CloudRegistrationOptions coarser = options;
  coarser.matching.voxel = kCoarser * first.matches.voxel;
  CloudRegistration second = attempt(source, target, coarser);
  CloudRegistration& better = second.verdict->log10_of_both <= first.verdict->log10_of_both ? second : first;
  better.attempts = 2;
  return std::move(better);
}

}  // namespace

CloudVerdict verify_registration(const Cloud& source, const Cloud& target, const CloudMatches& matches,
                                 const CloudMatchingOptions& options, Registration& registration) {
  if (!registration.has_pose() && !registration.refused) return {.of_correspondences = registration.status};
  const auto start = std::chrono::steady_clock::now();
  const PoseVerifier verifier({source, *matches.source_voxels, options.source_viewpoint},
                              {target, *matches.target_voxels, options.target_viewpoint}, matches.voxel, options.seed);
  const std::chrono::duration<double> prepared = std::chrono::steady_clock::now() - start;
  const CloudVerdict verdict = decide(verifier, matches.correspondences, registration);
  registration.stages.back().seconds += prepared.count();
  registration.seconds += prepared.count();
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
