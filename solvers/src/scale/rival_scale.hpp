// Whether rows whose evidence for a pose is thin tell of another scale.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

#include "call/solver_call.hpp"

namespace consimd::detail {

/// Takes a pose of little evidence away where the scale that pair lengths vote for gives one with more support than its
/// rival may have: a few neighbours among rows at another scale fit a rigid motion. No look at other poses.
void refuse_at_rival_scale(const Correspondences& correspondences, Registration& result);

/// `run_solver` at a known scale, which rows may speak against.
template <typename Options, typename Solve>
Registration run_at_known_scale(const Correspondences& correspondences, const Options& options, const Solve& solve) {
  return run_solver(correspondences, options,
                    [&](const Correspondences& rows, const Options& used, Registration& result) {
                      solve(rows, used, result);
                      refuse_at_rival_scale(rows, result);
                    });
}

}  // namespace consimd::detail
