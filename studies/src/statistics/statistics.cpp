#include <consimd/studies/statistics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

namespace consimd::studies {

Interval wilson_interval(std::size_t successes, std::size_t trials) {
  if (successes > trials) {
    throw std::invalid_argument(fmt::format("{} successes of {} trials: expected at most as many", successes, trials));
  }
  if (trials == 0) return {};
  constexpr double z = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const auto k = static_cast<double>(successes);
  const auto n = static_cast<double>(trials);
  const double centre = (k + z * z / 2.0) / (n + z * z);
  const double half = z / (n + z * z) * std::sqrt(k * (n - k) / n + z * z / 4.0);
  return {successes == 0 ? 0.0 : centre - half, successes == trials ? 1.0 : centre + half};
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace consimd::studies
