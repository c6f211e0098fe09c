// A solver of known scale where the scale is to be found.
#pragma once

#include <cstdint>
#include <functional>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

#include "call/solver_call.hpp"
#include "verdict/final_pose.hpp"

namespace consimd::detail {

/// Solves at scale 1 with the number of noise bounds, and of scales, that were chosen from.
using KnownScaleSolver = std::function<Registration(const Correspondences& scaled, std::uint32_t bounds_tried)>;

/// The scales that pairs vote for (`scale_voting`) are tried on sources multiplied by them, most votes first, until one
/// has a pose; a scale with votes nearly as many is tried as well, since its pose may be a rival. Scale and pose are
/// then refined in turn on all correspondences until both stand still, unless the solver's own estimate is asked for.
/// The pose is tested as one of that scale, its number of false poses multiplied by the number of scales that could be
/// told apart. The covariance of the pose includes what the scale's uncertainty adds to it.
Registration register_scaled(const Correspondences& correspondences, const CallOptions& options,
                             std::uint32_t bounds_tried, Refinement refinement, const KnownScaleSolver& solver);

}  // namespace consimd::detail
