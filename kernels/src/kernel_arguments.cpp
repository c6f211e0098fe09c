#include "kernel_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <consimd/kernels/working_length.hpp>

namespace consimd::detail {

RawView raw_view(const CorrespondenceView& view) noexcept {
  return {{view.source(0), view.source(1), view.source(2)},
          {view.target(0), view.target(1), view.target(2)},
          view.size(),
          view.padded_size()};
}

float working_length(const CorrespondenceView& view, double length, std::string_view name) {
  if (!std::isfinite(length) || length <= 0.0) {
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(length) +
                                ", expected a finite length above 0");
  }
  return static_cast<float>(consimd::working_length(view, length));
}

float ratio_bound(double ratio, std::string_view name) {
  if (!(ratio > 0.0 && ratio < 1.0)) {
    throw std::invalid_argument(std::string(name) + " is " + std::to_string(ratio) +
                                ", expected a share between 0 and 1, both excluded");
  }
  return static_cast<float>(std::max(ratio, 1e-9));
}

void require_size(std::string_view name, std::size_t got, std::size_t expected) {
  if (got == expected) return;
  throw std::invalid_argument(std::string(name) + " has " + std::to_string(got) + " elements, expected " +
                              std::to_string(expected));
}

void require_aligned(std::string_view name, const float* values) {
  if (reinterpret_cast<std::uintptr_t>(values) % 64 == 0) return;
  throw std::invalid_argument(std::string(name) + " is not aligned to 64 bytes");
}

void require_index(std::uint32_t index, std::size_t size) {
  if (index < size) return;
  throw std::out_of_range("index " + std::to_string(index) + " of " + std::to_string(size) + " correspondences");
}

}  // namespace consimd::detail
