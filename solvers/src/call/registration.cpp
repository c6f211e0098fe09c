#include <consimd/solvers/registration.hpp>

#include <oneapi/tbb/task_arena.h>

#include "call/solver_call.hpp"

namespace consimd {

std::string_view to_string(Status status) noexcept {
  switch (status) {
    case Status::success:
      return "success";
    case Status::too_few_correspondences:
      return "too_few_correspondences";
    case Status::no_consensus:
      return "no_consensus";
    case Status::degenerate_geometry:
      return "degenerate_geometry";
    case Status::ambiguous:
      return "ambiguous";
    case Status::budget_exhausted:
      return "budget_exhausted";
  }
  return "unknown";
}

Registration detail::start_registration(double noise_bound, double noise_bound_asked, std::uint64_t seed) {
  Registration result;
  result.seed = seed;
  result.isa = active_isa();
  result.threads = tbb::this_task_arena::max_concurrency();
  result.noise_bound = noise_bound;
  result.noise_bound_asked = noise_bound_asked;
  result.consistency_bound = 2.0 * noise_bound;
  return result;
}

}  // namespace consimd
