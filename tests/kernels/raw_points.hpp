// Clouds as raw arrays for the kernel tables, with any number in them.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "clouds/cloud_kernels.hpp"
#include "raw_cloud.hpp"

namespace consimd::test {

/// Bits of floats, every NaN as the same one: which of two NaNs an operation keeps is the processor's choice.
inline std::vector<std::uint32_t> bits_of(const float* values, std::size_t n) {
  std::vector<std::uint32_t> bits(n);
  std::transform(values, values + n, bits.begin(),
                 [](float value) { return std::isnan(value) ? 0x7fc00000u : std::bit_cast<std::uint32_t>(value); });
  return bits;
}

/// Points and normals of a RawCloud (its two sides), padded as a Cloud's are.
class RawPointCloud {
 public:
  RawPointCloud(const RawCloud& cloud, bool unit_normals) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (int row = 0; row < 6; ++row) rows_.emplace_back(cloud.padded() + 64, kNan);
    const detail::RawView view = cloud.view();
    for (std::size_t j = 0; j < cloud.size(); ++j) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        rows_[axis][j] = view.source[axis][j];
        rows_[3 + axis][j] = view.target[axis][j];
      }
      if (unit_normals) normalise(j);
    }
    size_ = cloud.size();
  }

  detail::RawPoints view() const {
    return {{rows_[0].data(), rows_[1].data(), rows_[2].data()},
            {rows_[3].data(), rows_[4].data(), rows_[5].data()},
            size_};
  }

 private:
  void normalise(std::size_t j) {
    const float length = std::hypot(rows_[3][j], rows_[4][j], rows_[5][j]);
    for (std::size_t axis = 3; axis < 6; ++axis) rows_[axis][j] /= length;
  }

  std::vector<ExactArray<float>> rows_;
  std::size_t size_;
};

/// Runs check(points, cloud, bound) for every kind of number and every length up to four words.
template <typename Check>
void for_every_point_cloud(Check check) {
  for_every_cloud([&](RawCloud& cloud, float bound) {
    const RawPointCloud points(cloud, cloud.size() % 2 == 0);
    check(points.view(), cloud, bound);
  });
}

}  // namespace consimd::test
