// The statistics that a study reports.
#pragma once

#include <cstddef>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace consimd {
namespace CONSIMD_EXPORT studies {

/// A 95 % confidence interval of a success probability.
struct Interval {
  double low = 0.0;
  double high = 1.0;
};

/// Wilson's score interval for `successes` of `trials` (E. B. Wilson, JASA 22, 1927). Unlike the normal approximation
/// it stays in [0, 1] and has a width at 0 and 100 %. No trials: [0, 1]. Throws std::invalid_argument if successes >
/// trials.
[[nodiscard]] Interval wilson_interval(std::size_t successes, std::size_t trials);

/// Middle value, or the mean of the two middle ones. Empty: NaN.
[[nodiscard]] double median(std::vector<double> values);

}  // namespace studies
}  // namespace consimd
