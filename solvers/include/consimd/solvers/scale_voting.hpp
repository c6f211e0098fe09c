// The scale between two clouds by votes of pairs of correspondences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

struct ScaleVotingOptions {
  double noise_bound = 0.0;  ///< tau, caller's unit of the target; finite and > 0
  std::uint64_t seed = 1;    ///< of the sample of voters and partners
  /// A pair speaks for the scales at which its lengths differ by less than this many noise bounds; > 0. Two would keep
  /// all pairs of inliers; those that one loses are outweighed by the outliers that it keeps away.
  double tolerance = 1.0;
  /// Correspondences that vote, each by its pairs with the same sample of partners; > 0. Fewer where there are fewer.
  /// They bound time and memory, which do not grow beyond some 8 MB.
  std::uint32_t max_voters = 1024;
  std::uint32_t max_partners = 4096;
  std::uint32_t max_scales = 3;  ///< scales returned at most, > 0
};

struct VotedScale {
  double scale = 1.0;
  double votes = 0.0;            ///< what the voters' pairs exceed chance by
  std::size_t voters = 0;        ///< that see the scale stand out
  std::size_t measurements = 0;  ///< pairs that the exact vote was taken of
};

/// The scales s, x_target = s R x_source + t, that most voters see stand out, in [2^-10, 2^10]; most votes first.
///
/// Every voter i lays the intervals of `scale_intervals` for its pairs with the partners over one another. An inlier's
/// pairs with other inliers all hold the true scale. How many hold a scale by chance is told by the same two sets of
/// lengths, those of i in the source and those in the target, paired at random. What exceeds this by more than two
/// standard deviations votes, with its square. The bins of this vote are about a percent wide; the scale is then the
/// exact minimiser of the truncated least squares cost (`adaptive_voting`) over the pairs around the fullest bin of the
/// voters that see it best. The intervals are not stored: N (N - 1) / 2 of them would fill the memory.
/// Nothing stands out among fewer than three correspondences, or where no length is above the noise: then none.
/// The same bits for any number of threads and every ISA. Throws std::invalid_argument on a bad option.
[[nodiscard]] std::vector<VotedScale> scale_voting(const Correspondences& correspondences,
                                                   const ScaleVotingOptions& options);

}  // namespace consimd
