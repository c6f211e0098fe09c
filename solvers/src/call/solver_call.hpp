// What every solver's call begins and ends with.
#pragma once

#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"

namespace consimd::detail {

/// A registration that says what is used and has no result yet.
Registration start_registration(double noise_bound, std::uint64_t seed);

/// The registration that `solve(result)` fills in, timed. It is called with three correspondences or more: fewer have
/// their status already. Throws std::invalid_argument on a bad noise bound.
template <typename Solve>
Registration run_solver(const Correspondences& correspondences, double noise_bound, std::uint64_t seed,
                        const Solve& solve) {
  require_length("noise_bound", noise_bound);
  Registration result = start_registration(noise_bound, seed);
  const StageClock clock(result.seconds);
  if (correspondences.size() < 3) {
    result.status = Status::too_few_correspondences;
  } else {
    solve(result);
  }
  return result;
}

}  // namespace consimd::detail
