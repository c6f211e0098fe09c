// Whether rows are mirror images of one another, which pairwise lengths cannot tell, and a pose fits what lies near a
// plane of them.
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

/// How many of all rows a reflection aligns that starts where it aligns `rows` best.
std::size_t mirrored_supporters(const Correspondences& correspondences, std::span<const std::uint32_t> rows,
                                double noise_bound);

/// Whether so many are clearly more than the pose has supporters.
[[nodiscard]] bool is_mirrored(std::size_t mirrored_supporters, std::size_t supporters);

/// Whether so many, found from a set among so many rows that agree in length, are a mirror image and no coincidence.
[[nodiscard]] bool is_mirror_image(std::size_t mirrored_supporters, std::size_t set_size, std::size_t rows);

/// Whether the pose is the part of a mirror image that a rotation covers: what lies near a plane, ground or a wall, is
/// about its own image. `supporters`: rows within the bound of the pose.
[[nodiscard]] bool is_part_of_a_mirror_image(const Correspondences& correspondences,
                                             std::span<const std::uint32_t> supporters, double noise_bound);

}  // namespace consimd::detail
