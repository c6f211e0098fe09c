// Taking a pose away.
#pragma once

#include <consimd/solvers/registration.hpp>

namespace consimd::detail {

/// The result with what belongs to its pose as constructed, and the status no_consensus.
inline void refuse(Registration& result) {
  const Registration none;
  result.status = Status::no_consensus;
  result.T_target_source = none.T_target_source;
  result.scale = none.scale;
  result.scale_deviation = none.scale_deviation;
  result.covariance = none.covariance;
  result.inliers.clear();
  result.runner_up.reset();
}

}  // namespace consimd::detail
