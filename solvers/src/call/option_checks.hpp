// Validation of options at a solver's door.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

template <typename T>
[[noreturn]] void reject_option(std::string_view name, T value, std::string_view expected) {
  std::ostringstream message;
  message << name << " is " << value << ", expected " << expected;
  throw std::invalid_argument(message.str());
}

/// Ten times as much is still a number.
inline constexpr double kLongest = 1e307;

inline void require_length(std::string_view name, double value) {
  if (!(value > 0.0) || !(value <= kLongest)) reject_option(name, value, "a length above 0 and at most 1e307");
}

/// Extents of points up to this, and down to one over it, leave room in double for what becomes of them in the caller's
/// unit: volumes, squares of variances.
inline constexpr double kLargestExtent = 1e75;

inline void require_within_reach(const Correspondences& correspondences, double noise_bound) {
  if (noise_bound * correspondences.scale() <= kLongest) return;
  reject_option("noise_bound", noise_bound, "one that is at most 1e307 times the extent of the points");
}

inline void require_usable_unit(const Correspondences& correspondences) {
  const double extent = 1.0 / correspondences.scale();
  if (extent <= kLargestExtent && extent >= 1.0 / kLargestExtent) return;
  reject_option("the extent of the points", extent, "one between 1e-75 and 1e75: choose another unit of length");
}

inline void require_above_zero(std::string_view name, std::uint32_t value) {
  if (value == 0) reject_option(name, value, "a number above 0");
}

inline void require_confidence(double value) {
  if (!(value > 0.0 && value < 1.0)) reject_option("confidence", value, "a probability between 0 and 1, both excluded");
}

/// The consistency matrix of all correspondences must fit its budget: there is no result without it.
inline void require_whole_matrix(std::size_t budget_bytes, std::size_t correspondences) {
  const std::size_t needed = ConsistencyMatrix::memory_bytes(correspondences);
  if (needed <= budget_bytes) return;
  reject_option("matrix_budget_bytes", budget_bytes,
                "at least " + std::to_string(needed) + " for " + std::to_string(correspondences) + " correspondences");
}

/// Rows that are far from all others have no place in the working frame: a caller who names one is told.
inline void require_near(const Correspondences& correspondences, std::span<const std::uint32_t> members) {
  for (const std::uint32_t row : correspondences.far_rows()) {
    if (std::ranges::find(members, row) == members.end()) continue;
    reject_option("members: one of them", row, "no row far from all others (see Correspondences::far_rows)");
  }
}

}  // namespace consimd::detail
