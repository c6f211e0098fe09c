// Descriptors in an order in which alike ones stand together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace consimd::detail {

/// Rows of `length` whole numbers in the order of the leaves of a k-d tree over the first `leading` of them: each
/// `leaf` rows from the first on lie near each other.
std::vector<std::uint32_t> alike_together(std::span<const std::int16_t> values, std::size_t length, std::size_t leading,
                                          std::size_t leaf);

}  // namespace consimd::detail
