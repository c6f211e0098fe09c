// What every solver's call begins and ends with.
#pragma once

#include <algorithm>
#include <cstdint>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>
#include <consimd/solvers/threads.hpp>

#include "call/distinct_rows.hpp"
#include "call/option_checks.hpp"
#include "call/stage_clock.hpp"

namespace consimd::detail {

/// What every solver's options have.
struct CallOptions {
  double noise_bound = 0.0;  ///< caller's unit
  std::uint64_t seed = 1;
  int threads = 0;
};

/// A registration that says what is used and has no result yet. `noise_bound`: used and asked for.
Registration start_registration(double noise_bound, double noise_bound_asked, std::uint64_t seed);

/// The registration that `solve(rows, options, result)` fills in, timed. It is called with rows that are no copies and
/// not far from all others, three or more (fewer have their status already), and with a noise bound that the working
/// frame resolves; the inliers are then those of all rows. Throws std::invalid_argument on a bad noise bound or unit.
template <typename Options, typename Solve>
Registration run_solver(const Correspondences& correspondences, const Options& asked, const Solve& solve) {
  require_length("noise_bound", asked.noise_bound);
  require_usable_unit(correspondences);
  require_within_reach(correspondences, asked.noise_bound);
  Registration result;
  run_on_threads(asked.threads, [&] {
    Options options = asked;
    options.noise_bound = std::max(asked.noise_bound, correspondences.resolution());
    result = start_registration(options.noise_bound, asked.noise_bound, options.seed);
    const StageClock clock(result.seconds);
    const DistinctRows rows(correspondences);
    if (rows.correspondences().size() < 3) {
      // Copies of one another are enough in number and coincide.
      const bool copies = correspondences.size() - correspondences.far_rows().size() >= 3;
      result.status = copies ? Status::degenerate_geometry : Status::too_few_correspondences;
    } else {
      solve(rows.correspondences(), options, result);
      rows.restore(result.inliers);
    }
  });
  return result;
}

}  // namespace consimd::detail
