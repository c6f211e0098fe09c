// Points that are in many rows: landmarks matched with all others, the images of a symmetric part.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Whether the points of both clouds are in six rows each or more, as far as some pairs of rows from all over tell.
[[nodiscard]] bool many_to_many(const CorrespondenceView& view);

/// Rows, ascending, that have the source or the target of one of `members` and are none of them. members: ascending.
[[nodiscard]] std::vector<std::uint32_t> rows_sharing_a_point(const CorrespondenceView& view,
                                                              std::span<const std::uint32_t> members);

}  // namespace consimd::detail
