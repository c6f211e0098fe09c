#include "grid/box.hpp"

#include <algorithm>
#include <cstddef>

namespace consimd::features::detail {

Box box_around(const Cloud& cloud) {
  Box box;
  if (cloud.empty()) return box;
  // Side by side, as a compiler wants them for vectors; the smallest number does not depend on the order.
  constexpr std::size_t kLanes = 16;
  const std::size_t whole = cloud.size() - cloud.size() % kLanes;
  for (std::size_t c = 0; c < 3; ++c) {
    const float* points = cloud.view().points(c);
    std::array<float, kLanes> low;
    std::array<float, kLanes> high;
    low.fill(points[0]);
    high.fill(points[0]);
    for (std::size_t i = 0; i < whole; i += kLanes) {
      for (std::size_t l = 0; l < kLanes; ++l) low[l] = points[i + l] < low[l] ? points[i + l] : low[l];
      for (std::size_t l = 0; l < kLanes; ++l) high[l] = points[i + l] > high[l] ? points[i + l] : high[l];
    }
    box.low[c] = *std::min_element(low.begin(), low.end());
    box.high[c] = *std::max_element(high.begin(), high.end());
    for (std::size_t i = whole; i < cloud.size(); ++i) {
      box.low[c] = std::min(box.low[c], points[i]);
      box.high[c] = std::max(box.high[c], points[i]);
    }
  }
  return box;
}

double extent(const Cloud& cloud) {
  const Box box = box_around(cloud);
  double longest = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    longest = std::max(longest, static_cast<double>(box.high[c]) - static_cast<double>(box.low[c]));
  }
  return longest / cloud.scale();
}

}  // namespace consimd::features::detail
