// A solver on the rows that a filter keeps, judged on all rows.
#pragma once

#include <cstdint>
#include <functional>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/solvers/registration.hpp>

namespace consimd::detail {

/// Runs `solver` on the rows that tcf_filter keeps of `correspondences`. Its pose and runner-up are refined, tested and
/// given their inliers on all rows, as if the default search had met them there; without a pose its status stands, but
/// that few rows were kept is no_consensus. `bounds_tried`: as in TcfOptions.
Registration register_filtered(const Correspondences& correspondences, double noise_bound, std::uint32_t bounds_tried,
                               std::uint64_t seed, const std::function<Registration(const Correspondences&)>& solver);

}  // namespace consimd::detail
