// What matchers keep: pairings within strata of correspondences whose sources are alike, and what these give a pose.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"

namespace consimd::detail {

/// Bounds that a pose is tested at, in noise bounds: supporters of a true pose crowd at small residuals.
inline constexpr std::array kTestedBounds{1.0, 0.7, 0.5, 0.35};

/// Number of hits among trials, at each of kTestedBounds.
struct PairingHits {
  std::array<double, kTestedBounds.size()> hits{};
  double trials = 0.0;
};

inline constexpr std::size_t kStratumRows = 32;

/// Correspondences in strata of sources that have some of their coordinates about equal.
class Strata {
 public:
  /// `first`: the position in `rows` of each stratum's first row, ascending, and the number of rows. Strata have at
  /// most kStratumRows rows.
  Strata(std::vector<std::uint32_t> rows, std::vector<std::uint32_t> first);

  /// How often `pose` takes a source to the target of another row of its stratum whose source is further away than
  /// `apart`. Every row counts as much, whatever its number of such rows is: the hits are their mean share in all
  /// trials. `matched` at the pose are no hit. `bound`, `apart`: caller's unit.
  [[nodiscard]] PairingHits support(const CorrespondenceView& view, const WorkingPose& pose, double bound, double apart,
                                    const MatchedPoints& matched) const;

  /// How often two correspondences whose targets are exchanged for others of their strata agree in length, to within
  /// twice the tested bounds. The same pairs are drawn in every call.
  [[nodiscard]] PairingHits lengths(const CorrespondenceView& view, double bound, std::uint32_t pairs) const;

 private:
  std::vector<std::uint32_t> rows_;        // stratum by stratum
  std::vector<std::uint32_t> first_;       // position in rows_ of a stratum's first; one more: the end
  std::vector<std::uint32_t> stratum_of_;  // by position
};

/// Strata by everything that matchers are known to keep of a place, each alone and together: the position along the
/// principal axes of the sources (height, position along a wall or in a corridor's cross-section), the distance from
/// the origin of the caller's frame and from the centroid (the range about a sensor, wherever it is; nothing is lost
/// where there is none), and the position itself (clusters, surfaces, lines).
std::vector<Strata> kept_strata(const Correspondences& correspondences);

/// The most telling of them, of a sample of the rows.
std::vector<Strata> sampled_strata(const Correspondences& correspondences);

/// Distance, in the caller's unit, up to which outliers move as one: from there on, two correspondences that are no
/// supporters of the pose have targets as far apart as their sources hardly more often than chance has it. Between
/// `least` and `most`, caller's unit.
double coherence_length(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double least,
                        double most);

}  // namespace consimd::detail
