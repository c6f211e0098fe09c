// Models of outliers, for tests that take them in turn.
#pragma once

#include <consimd/synth/hard_problems.hpp>

#include <array>
#include <cstddef>
#include <ostream>

namespace consimd::synth {

inline const char* name_of(OutlierModel model) {
  constexpr std::array kNames{"uniform", "permuted", "clustered", "one_to_many", "many_to_many", "alike"};
  return kNames[static_cast<std::size_t>(model)];
}

inline void PrintTo(OutlierModel model, std::ostream* out) { *out << name_of(model); }

}  // namespace consimd::synth

namespace consimd::test {

/// All but alike, far more of whose rows lie on one motion than of the others.
inline constexpr std::array kOutlierModels{synth::OutlierModel::uniform, synth::OutlierModel::permuted,
                                           synth::OutlierModel::clustered, synth::OutlierModel::one_to_many,
                                           synth::OutlierModel::many_to_many};

}  // namespace consimd::test
