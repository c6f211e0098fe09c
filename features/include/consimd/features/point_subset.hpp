// Some of the points of a cloud.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/cloud.hpp>
#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT features {

/// `count` of the rows 0 to size - 1, ascending, each set of them as likely as any other; all of them where there are
/// no more. A function of its arguments alone. size < 2^32.
[[nodiscard]] std::vector<std::uint32_t> random_subset(std::size_t size, std::size_t count, std::uint64_t seed);

/// `count` rows of a cloud, all where there are no more, in the order in which they are chosen: the first by the seed,
/// each of the others the point whose nearest chosen one is furthest away, the lowest of equally far ones (Eldar,
/// Lindenbaum, Porat, Zeevi, "The farthest point strategy for progressive image sampling", IEEE TIP 1997). Copies of
/// chosen points come last. They spread evenly over the surface, however dense the cloud is there. The same for any
/// number of threads and instruction set.
[[nodiscard]] std::vector<std::uint32_t> farthest_subset(const Cloud& cloud, std::size_t count, std::uint64_t seed);

}  // namespace features
}  // namespace consimd
