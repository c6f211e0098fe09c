// What a benchmarked kernel computes, so that it can be checked before it is timed.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::bench {

/// A kernel fills the members that it has and leaves the others empty.
struct Outcome {
  std::vector<std::uint32_t> counts;
  std::vector<std::uint64_t> bits;
  std::vector<PoseSupport> support;
  std::vector<WorkingPose> poses;
  std::vector<float> sums;
  RigidMoments moments{};
  ConsistencyMatrix matrix;
};

/// The same bits: what every instruction set owes the scalar reference.
[[nodiscard]] bool identical(const Outcome& a, const Outcome& b);

/// The same results but for rounding and the cases that it tips over a threshold: what a baseline owes the reference.
/// Counts and scores within 3 + 1 %; moments within 0.1 % of the weight (coordinates are below 1); of minimal fits,
/// which thin triangles make ill-conditioned, 98 % within 0.01 in every entry. Sets and matrices are compared by their
/// counts.
[[nodiscard]] bool close(const Outcome& baseline, const Outcome& reference);

}  // namespace consimd::bench
