#include "street.hpp"

#include <cmath>
#include <random>

namespace consimd::bench {

Places street(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<std::int32_t>(random()) * 0x1p-31; };
  Places points(count);
  for (auto& p : points) {
    const double along = 40.0 * uniform();
    const double across = uniform();
    switch (random() % 4) {
      case 0:
        p = {along, 10.0 + std::sin(0.7 * along), 4.0 + 4.0 * across};
        break;
      case 1:
        p = {along, -10.0 - 0.5 * std::floor(std::fmod(along + 40.0, 6.0)), 4.0 + 4.0 * across};
        break;
      default:
        p = {along, 10.0 * across, 0.05 * along * across};
    }
    for (double& x : p) x += 0.02 * uniform();
  }
  return points;
}

Cloud cloud_of(const Places& points) {
  return Cloud(PointSpan<double>::interleaved(points.front().data(), points.size()));
}

double spacing(std::size_t size) { return 2.0 * std::sqrt(2900.0 / static_cast<double>(size)); }

}  // namespace consimd::bench
