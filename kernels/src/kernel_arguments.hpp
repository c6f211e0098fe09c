// Checks and conversions between the public functions and the kernel tables.
#pragma once

#include <consimd/kernels/correspondences.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "kernel_table.hpp"

namespace consimd::detail {

RawView raw_view(const CorrespondenceView& view) noexcept;

/// consimd::working_length(view, length) in single precision. Throws std::invalid_argument unless the length is finite
/// and > 0.
float working_length(const CorrespondenceView& view, double length, std::string_view name);

/// Throws std::invalid_argument unless `ratio` lies between 0 and 1, both excluded.
float ratio_bound(double ratio, std::string_view name);

/// Throws std::invalid_argument unless got == expected.
void require_size(std::string_view name, std::size_t got, std::size_t expected);

/// Throws std::invalid_argument unless the values begin at a multiple of 64 bytes.
void require_aligned(std::string_view name, const float* values);

/// Throws std::out_of_range unless index < size.
void require_index(std::uint32_t index, std::size_t size);

}  // namespace consimd::detail
