// Correspondences that tell of different places.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Rows, ascending, no two of which have both their sources and their targets within `radius` (caller's unit): where
/// a cluster of sources is matched to a cluster of targets, a few rows stand for all of them. A row stays if none
/// before it that stays is that close. Far rows are none.
[[nodiscard]] std::vector<std::uint32_t> independent_rows(const CorrespondenceView& view, double radius);

/// Independent rows at a noise bound (caller's unit), for a search where the support of clusters does not outweigh that
/// of a pose whose supporters are few but far apart. None where they are fewer than three or nearly all.
[[nodiscard]] std::vector<std::uint32_t> rows_for_another_search(const CorrespondenceView& view, double noise_bound);

/// Whether `rows` tell of few places, each of which three of them or more have seen within the noise of one another.
/// Told from some of them.
[[nodiscard]] bool are_of_few_places(const CorrespondenceView& view, const std::vector<std::uint32_t>& rows,
                                     double noise_bound);

}  // namespace consimd::detail
