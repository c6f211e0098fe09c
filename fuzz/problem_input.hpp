// Correspondences from bytes.
#pragma once

#include <fuzzer/FuzzedDataProvider.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

namespace consimd::fuzz {

/// Rows of few distinct values, so that points coincide, lie on lines and planes, and repeat. Some are rigidly moved
/// ones, some come from far away, in any unit.
inline Correspondences make_correspondences(FuzzedDataProvider& input, std::size_t most) {
  const auto rows = input.ConsumeIntegralInRange<std::size_t>(0, most);
  const auto values = input.ConsumeIntegralInRange<int>(1, 127);  // of a coordinate, on either side of 0
  const double unit = std::ldexp(1.0, input.ConsumeIntegralInRange<int>(-300, 300));
  const std::array<double, 2> offsets{input.ConsumeBool() ? 0.0 : std::ldexp(unit, 20),
                                      input.ConsumeBool() ? 0.0 : std::ldexp(unit, 30)};
  std::vector<double> source, target;
  for (std::size_t row = 0; row < rows; ++row) {
    const bool moved = input.ConsumeBool();  // by a quarter turn and a step
    std::array<double, 3> p{}, q{};
    for (double& x : p) x = input.ConsumeIntegralInRange<int>(-values, values);
    if (moved) {
      q = {-p[1] + 7.0, p[0] - 3.0, p[2] + 1.0};
    } else {
      for (double& x : q) x = input.ConsumeIntegralInRange<int>(-values, values);
    }
    for (const double x : p) source.push_back(unit * x + offsets[0]);
    for (const double x : q) target.push_back(unit * x + offsets[1]);
  }
  return {PointSpan<double>::interleaved(source.data(), rows), PointSpan<double>::interleaved(target.data(), rows)};
}

/// A length that matters for such rows, or any double.
inline double make_bound(FuzzedDataProvider& input, const Correspondences& correspondences) {
  if (input.ConsumeBool()) return input.ConsumeFloatingPoint<double>();
  return std::ldexp(1.0 / correspondences.scale(), -input.ConsumeIntegralInRange<int>(0, 12));
}

}  // namespace consimd::fuzz
