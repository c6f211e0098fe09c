// The types that the vector bodies compute with, of one architecture of xsimd.
#pragma once

#include <cstddef>
#include <cstdint>

#include <xsimd/xsimd.hpp>

namespace consimd::detail {

template <typename Arch>
using Batch = xsimd::batch<float, Arch>;
template <typename Arch>
using Mask = xsimd::batch_bool<float, Arch>;

template <typename Arch>
using IntBatch = xsimd::batch<std::int32_t, Arch>;
template <typename Arch>
using IntMask = xsimd::batch_bool<std::int32_t, Arch>;

template <typename Arch>
inline constexpr std::size_t kWidth = Batch<Arch>::size;

template <typename Arch>
inline std::uint32_t popcount(std::uint64_t bits) {
  return static_cast<std::uint32_t>(__builtin_popcountll(bits));
}

}  // namespace consimd::detail
