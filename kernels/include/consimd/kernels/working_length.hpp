// Lengths of the caller's unit in the working frame.
#pragma once

#include <algorithm>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// `length` in the working frame of the view, as every kernel takes it: kept within [1e-9, 16]. Below, it is finer than
/// single precision resolves; above, it exceeds every distance; and its fourth power stays a normal number in between.
[[nodiscard]] inline double working_length(const CorrespondenceView& view, double length) noexcept {
  return std::clamp(length * view.scale(), 1e-9, 16.0);
}

}  // namespace consimd
