// Whether targets are the mirror image of their sources, which pairwise lengths cannot tell, and a pose fits what lies
// near a plane of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// The moments are those of sources whose first axis is reversed: a rotation that fits them is a reflection of the
/// rows.
RigidMoments mirrored(const RigidMoments& moments);

/// Rows that a reflection aligns: of those that it was first fitted to, and of all.
struct MirroredSupport {
  std::size_t of_set = 0;
  std::size_t of_all = 0;
};

/// The support of the reflection that starts where it aligns the rows of `set` best. noise_bound: caller's unit.
[[nodiscard]] MirroredSupport mirrored_support(const Correspondences& correspondences,
                                               std::span<const std::uint32_t> set, double noise_bound);

/// Whether that is clearly more than the pose has supporters.
[[nodiscard]] bool is_mirrored(const MirroredSupport& image, std::size_t supporters);

/// Whether so many of the set, found among so many rows, are a mirror image and no coincidence.
[[nodiscard]] bool is_mirror_image(const MirroredSupport& image, std::size_t set_size, std::size_t rows);

/// Whether the pose is the part of a mirror image that a rotation covers: what lies near a plane, ground or a wall, is
/// about its own image. `supporters`: rows within the bound of the pose.
[[nodiscard]] bool is_part_of_a_mirror_image(const Correspondences& correspondences,
                                             std::span<const std::uint32_t> supporters, double noise_bound);

}  // namespace consimd::detail
