#include <consimd/features/register_clouds.hpp>

#include <consimd/solvers/solver.hpp>

namespace consimd::features {

Refinement refine_registration(const CloudMatches& matches, RefinementMethod method, Registration& registration) {
  const Refinement refined =
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
  CloudRegistration result{match_clouds(source, target, options.matching), {}};
  result.registration =
      register_by_name(options.solver, result.matches.correspondences,
                       {.noise_bound = options.noise_bound.value_or(result.matches.noise_bound), .seed = options.seed});
  if (options.refine && result.registration.has_pose()) {
    result.refinement = refine_registration(result.matches, *options.refine, result.registration);
  }
  return result;
}

}  // namespace consimd::features
