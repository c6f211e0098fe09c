// Batched minimal rigid fits from three correspondences.
#pragma once

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace CONSIMD_EXPORT consimd {

/// poses[h] = the least-squares rigid pose of triples[h], with its triangles' orientation kept (never a reflection).
/// In closed form: each triangle spans a plane; the frames of both planes are matched and the remaining rotation within
/// the plane is the normalised sum of complex products (2-D Kabsch). A triple whose triangle is degenerate in either
/// cloud (sine at its first corner below 1e-5, or equal points) gives a pose of NaN, which no correspondence supports.
/// triples, poses: H. Throws std::invalid_argument on mismatched sizes, std::out_of_range on a bad index.
void three_point_fits(const CorrespondenceView& view, std::span<const IndexTriple> triples,
                      std::span<WorkingPose> poses);

}  // namespace consimd
