// Correspondences whose sources are alike, and what pairing within them gives.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"
#include "verdict/reached_targets.hpp"

namespace consimd::detail {

/// Bounds that a pose is tested at, in noise bounds: supporters of a true pose crowd at small residuals.
inline constexpr std::array kTestedBounds{1.0, 0.7, 0.5, 0.35};

/// Number of hits among trials, at each of kTestedBounds.
struct PairingHits {
  std::array<double, kTestedBounds.size()> hits{};
  double trials = 0.0;
};

/// Counts a trial: whether the sources of `a` and `b` are as far apart as the targets of `from` and `to`, to within
/// `tolerance` (working frame) times each of kTestedBounds. A pair as it is, forwards or backwards, is no trial.
void add_length(PairingHits& hits, const CorrespondenceView& view, std::uint32_t a, std::uint32_t b, std::uint32_t from,
                std::uint32_t to, double tolerance);

inline constexpr std::size_t kStratumRows = 32;

/// Rows stratum by stratum, and the position among them of each stratum's first, ascending; one more: their number.
struct Partition {
  std::vector<std::uint32_t> rows;
  std::vector<std::uint32_t> first;
};

/// Correspondences in strata of sources that have some of their coordinates about equal.
class Strata {
 public:
  /// Strata have at most kStratumRows rows. Rows whose sources are closer than `apart` (caller's unit) are no test of
  /// each other. Keeps the view.
  Strata(const CorrespondenceView& view, Partition partition, double apart);

  /// How often `pose` takes a source to the target of another row of its stratum, but for those too close. Every row
  /// counts as much, whatever its number of such rows is: the hits are their mean share in all trials. `bound`:
  /// caller's unit.
  [[nodiscard]] PairingHits support(const WorkingPose& pose, double bound, const MatchedPoints& matched) const;

  /// The same from all that the pose reaches, faster where that is little. Of strata that have all rows.
  [[nodiscard]] PairingHits support(std::span<const ReachedTarget> reached, double bound,
                                    const MatchedPoints& matched) const;

  /// How often two correspondences whose targets are exchanged for others of their strata agree in length, to within
  /// twice the tested bounds. The same pairs are drawn in every call.
  [[nodiscard]] PairingHits lengths(double bound, std::uint32_t pairs) const;

 private:
  using Limits = std::array<float, kTestedBounds.size()>;  // squared residuals, working frame
  [[nodiscard]] Limits limits(double bound) const;
  // Adds a hit, of a share of its row, at the bounds that it is within.
  static void add(PairingHits& hits, double share, float squared, const Limits& limits);
  // The hits as their mean share in all trials.
  [[nodiscard]] PairingHits mean(PairingHits hits) const;
  // Bits of the rows of its stratum that the row at a position is tested with.
  [[nodiscard]] std::uint32_t mates(std::uint32_t position) const;

  CorrespondenceView view_;
  std::vector<std::uint32_t> rows_;        // stratum by stratum
  std::vector<std::uint32_t> first_;       // position in rows_ of a stratum's first; one more: the end
  std::vector<std::uint32_t> stratum_of_;  // by position
  std::vector<std::uint32_t> position_;    // in rows_, by row
  std::vector<std::uint32_t> stratum_of_row_;
  // By position, coordinate by coordinate; a stratum more at the end.
  std::array<std::vector<float>, 3> sources_;
  std::array<std::vector<float>, 3> targets_;
  float apart_;  // squared, working frame
  double trials_ = 0.0;
};

}  // namespace consimd::detail
