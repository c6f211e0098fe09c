// What matchers keep: strata of correspondences whose sources are alike in it.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "verdict/strata.hpp"

namespace consimd::detail {

/// Strata by everything that matchers are known to keep of a place, each alone and together: the position along the
/// principal axes of the sources (height, position along a wall or in a corridor's cross-section), the distance from
/// their viewpoint and from the centroid (the range about a sensor, wherever it is; nothing is lost
/// where there is none), and the position itself (clusters, surfaces, lines). Rows are cut into the strata of a kind
/// when these are first asked for, at whatever bound; several threads may ask for different kinds at a time.
class KeptStructure {
 public:
  /// Keeps a pointer to the correspondences.
  explicit KeptStructure(const Correspondences& correspondences);

  [[nodiscard]] std::size_t kinds() const;
  /// Those of a kind. By more than one coordinate rows are cut in two ways: what lies on either side of a cut is in one
  /// stratum the other way. `apart`: see Strata. The strata keep a view of the correspondences.
  [[nodiscard]] std::vector<Strata> strata(std::size_t kind, double apart) const;

  /// The most telling ones, of a sample of the rows.
  [[nodiscard]] static std::vector<Strata> sampled(const Correspondences& correspondences, double apart);

 private:
  struct Sorted;

  const Correspondences* correspondences_;
  mutable std::once_flag is_sorted_;
  mutable std::shared_ptr<const Sorted> sorted_;
  mutable std::vector<std::vector<Partition>> partitions_;  // by kind
};

}  // namespace consimd::detail
