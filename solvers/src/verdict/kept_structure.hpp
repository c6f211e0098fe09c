// What matchers keep: strata of correspondences whose sources are alike in it.
#pragma once

#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "verdict/strata.hpp"

namespace consimd::detail {

/// Strata by everything that matchers are known to keep of a place, each alone and together: the position along the
/// principal axes of the sources (height, position along a wall or in a corridor's cross-section), the distance from
/// the origin of the caller's frame and from the centroid (the range about a sensor, wherever it is; nothing is lost
/// where there is none), and the position itself (clusters, surfaces, lines). By more than one of them rows are cut
/// into strata in two ways: what lies on either side of a cut is in one stratum the other way. `apart`: see Strata. The
/// strata keep a view of the correspondences.
std::vector<Strata> kept_strata(const Correspondences& correspondences, double apart);

/// The most telling of them, of a sample of the rows.
std::vector<Strata> sampled_strata(const Correspondences& correspondences, double apart);

}  // namespace consimd::detail
