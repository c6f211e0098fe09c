// What the sampling stages hand to one another.
#pragma once

#include <cstdint>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Correspondences that a stage keeps.
struct ConsensusSet {
  std::vector<std::uint32_t> members;  ///< rows of the input, ascending
  std::uint32_t score = 0;             ///< what the stage maximised: the set's size, or its size after pruning
  std::uint64_t iterations = 0;        ///< hypotheses drawn
};

}  // namespace consimd
