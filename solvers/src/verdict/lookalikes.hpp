// Correspondences whose sources look alike to the matcher, and what pairing among them gives.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

#include "support/repeated_points.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {

/// Sources that were matched with one place of the target look alike: windows of a facade, legs of chairs. What one of
/// them was matched with elsewhere, another could have been as well. Nothing where a place is in one row alone.
class Lookalikes {
 public:
  /// Sources closer than `apart` are no test of each other. Both in the caller's unit. Keeps the view.
  Lookalikes(const CorrespondenceView& view, double noise_bound, double apart);

  /// How often `pose` takes a source to a target that another source was matched with which looks like it, but for
  /// places that it was itself matched with. Counted as Strata::support does. `bound`: caller's unit.
  [[nodiscard]] PairingHits support(const WorkingPose& pose, double bound, const MatchedPoints& matched) const;

  /// How often lengths agree among targets exchanged in this way, see Strata::lengths.
  [[nodiscard]] PairingHits lengths(double bound, std::uint32_t pairs) const;

 private:
  [[nodiscard]] std::uint32_t first(std::uint32_t row) const { return row == 0 ? 0 : end_[row - 1]; }

  CorrespondenceView view_;
  std::vector<std::uint32_t> mates_;  // row by row: rows with targets that its source could have been matched with
  std::vector<std::uint32_t> end_;    // of a row's mates
};

}  // namespace consimd::detail
