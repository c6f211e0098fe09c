// TCF from end to end as a researcher writes it from the paper: double precision, vectors of points, one hypothesis at
// a time, one thread. A baseline for the speed and the recall of whole registrations.
#pragma once

#include <cstdint>
#include <optional>

#include "eigen_baseline.hpp"

namespace consimd::bench {

struct EigenTcfOptions {
  double noise_bound = 0.0;     ///< tau, metres: the fit stops at a scale in metres
  double confidence = 0.99;     ///< of each of the three RANSACs
  int max_iterations = 10'000;  ///< likewise; the paper names no cap, its authors' code has this one for one point
  /// Reduce the sets of one-point RANSAC to members that agree pairwise, as the authors' code does but the paper does
  /// not say: E ones in the consistency matrix of a set leave the ceil(sqrt(E)) members of highest degree, repeatedly.
  bool prune = false;
  std::uint64_t seed = 1;
};

namespace eigen {

/// Algorithms 1 to 3 of the paper, with the rotation-invariant reading of the angle test (bound 2 tau) and the Cauchy
/// weights of the authors' code. Nothing where the filters leave fewer than three correspondences.
CONSIMD_BASELINE std::optional<EigenPose> register_tcf(const EigenCloud& cloud, const EigenTcfOptions& options);

}  // namespace eigen
}  // namespace consimd::bench
