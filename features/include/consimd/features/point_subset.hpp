// Some of the points of a cloud.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// `count` of the rows 0 to size - 1, ascending, each set of them as likely as any other; all of them where there are
/// no more. A function of its arguments alone. size < 2^32.
[[nodiscard]] std::vector<std::uint32_t> random_subset(std::size_t size, std::size_t count, std::uint64_t seed);

}  // namespace features
}  // namespace consimd
