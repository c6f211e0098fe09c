// Points that follow one another in a cloud. No standard-library containers here: the ISA-specific sources include this
// file.
#pragma once

#include <cstdint>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Points `first` to `last` - 1.
struct PointRun {
  std::uint32_t first;
  std::uint32_t last;
};

}  // namespace consimd
