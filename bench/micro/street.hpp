// The clouds of the benchmarks: samples of a made-up street.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/cloud.hpp>

namespace consimd::bench {

using Places = std::vector<std::array<double, 3>>;

/// `count` points of a road between uneven walls, 80 m by 20 m, with 2 cm of noise; of the same area whatever the
/// count.
[[nodiscard]] Places street(std::size_t count, std::uint32_t seed);

[[nodiscard]] Cloud cloud_of(const Places& points);

/// Twice the mean distance of neighbours in a street of `size` points, about.
[[nodiscard]] double spacing(std::size_t size);

}  // namespace consimd::bench
