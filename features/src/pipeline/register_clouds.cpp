#include <consimd/features/register_clouds.hpp>

#include <consimd/solvers/solver.hpp>

namespace consimd::features {

CloudRegistration register_clouds(const Cloud& source, const Cloud& target, const CloudRegistrationOptions& options) {
  CloudRegistration result{match_clouds(source, target, options.matching), {}};
  result.registration =
      register_by_name(options.solver, result.matches.correspondences,
                       {.noise_bound = options.noise_bound.value_or(result.matches.noise_bound), .seed = options.seed});
  return result;
}

}  // namespace consimd::features
