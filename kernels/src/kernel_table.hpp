// The table of functions that one instruction set provides. Plain data only: this header is seen by every ISA-specific
// source.
#pragma once

#include <cstddef>
#include <cstdint>

#include <consimd/kernels/kernel_data.hpp>

#include "clouds/cloud_kernels.hpp"

namespace consimd::detail {

/// A CorrespondenceView as bare pointers: 64-byte aligned, `padded` a multiple of 64, NaN from `size` on.
struct RawView {
  const float* source[3];
  const float* target[3];
  std::size_t size;
  std::size_t padded;
};

/// RobustWeight in the working frame, single precision, ready to multiply.
struct RawWeight {
  WeightFunction function;
  float inverse_squared_scale;  ///< cauchy: 1 / scale^2; student_uniform: 1 / (2 exponent scale^2); truncated: unused
  float squared_cutoff;
  float odds;               ///< above 0: at 0 a power that overflows would give NaN
  std::uint32_t squarings;  ///< log2 of the exponent
};

/// What a pair must hold to be kept in a separated consistency matrix.
struct SeparatedBounds {
  float bound;       ///< on the difference of the two lengths
  float separation;  ///< below their sum
};

/// What a pair must hold where its lengths are compared both ways.
struct RatioBounds {
  float bound;  ///< on the difference of the two lengths
  float ratio;  ///< on that of their squares, as a share of the squares' sum
};

/// Every pointer is set in every table. Lengths are in the working frame; batches may be empty; `bits` rows are
/// padded/64 words. No function allocates, throws or reads beyond `padded` floats.
struct KernelTable {
  void (*length_counts)(const RawView&, const std::uint32_t* seeds, std::size_t n, float bound, std::uint32_t* counts);
  void (*length_bits)(const RawView&, const std::uint32_t* seeds, std::size_t n, float bound, std::uint64_t* bits,
                      std::uint32_t* counts);
  void (*angle_counts)(const RawView&, const IndexPair* pairs, std::size_t n, float bound, std::uint32_t* counts);
  void (*angle_bits)(const RawView&, const IndexPair* pairs, std::size_t n, float bound, std::uint64_t* bits,
                     std::uint32_t* counts);
  void (*alignment_counts)(const RawView&, const WorkingPose* poses, std::size_t n, float bound, std::uint32_t* counts);
  void (*alignment_scores)(const RawView&, const WorkingPose* poses, std::size_t n, float bound, PoseSupport* support);
  void (*alignment_bits)(const RawView&, const WorkingPose* poses, std::size_t n, float bound, std::uint64_t* bits,
                         std::uint32_t* counts);
  /// squared: view.padded floats.
  void (*alignment_residuals)(const RawView&, const WorkingPose&, float* squared);
  void (*weighted_moments)(const RawView&, const float* weights, RigidMoments* moments);
  void (*subset_moments)(const RawView&, const std::uint64_t* bits, RigidMoments* moments);
  void (*robust_moments)(const RawView&, const WorkingPose&, const RawWeight&, RigidMoments* moments);
  void (*three_point_fits)(const RawView&, const IndexTriple* triples, std::size_t n, WorkingPose* poses);
  /// bits: view.size rows of padded/64 words, those of length_bits, written whole; degrees: view.size.
  void (*consistency_matrix)(const RawView&, float bound, std::uint64_t* bits, std::uint32_t* degrees);
  void (*separated_matrix)(const RawView&, SeparatedBounds, std::uint64_t* bits, std::uint32_t* degrees);
  void (*ratio_matrix)(const RawView&, RatioBounds, std::uint64_t* bits, std::uint32_t* degrees);
  std::uint32_t (*and_popcount)(const std::uint64_t* a, const std::uint64_t* b, std::size_t words);
  /// counts[r] = popcount(set & row rows[r]), rows of `words` words.
  void (*and_popcount_rows)(const std::uint64_t* matrix, std::size_t words, const std::uint64_t* set,
                            const std::uint32_t* rows, std::size_t n, std::uint32_t* counts);
  /// sums[r] = sum of values[j] over the ones j of row r. n rows of `words` words; values: 64 * words.
  void (*masked_row_sums)(const std::uint64_t* rows, std::size_t words, std::size_t n, const float* values,
                          float* sums);
  void (*length_disagreement)(const RawView&, const std::uint32_t* seeds, std::size_t n, RatioBounds, float* costs);
  /// lows, highs: view.padded floats.
  void (*scale_intervals)(const RawView&, std::uint32_t seed, float bound, float* lows, float* highs);
  CloudKernels clouds;
};

// One table per instruction set; only those that the build compiles are defined (CONSIMD_HAVE_SSE2, ..., set by CMake
// for dispatch.cpp).
namespace scalar {
const KernelTable& table() noexcept;
}
namespace sse2 {
const KernelTable& table() noexcept;
}
namespace avx2 {
const KernelTable& table() noexcept;
}
namespace avx512 {
const KernelTable& table() noexcept;
/// Puts in the functions that need AVX512_VPOPCNTDQ, which not every AVX-512 processor has.
void use_vector_popcount(KernelTable& table) noexcept;
}  // namespace avx512
namespace neon {
const KernelTable& table() noexcept;
}

}  // namespace consimd::detail
