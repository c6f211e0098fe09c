// Points in cubes, and cubes in order.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <consimd/kernels/cloud.hpp>

namespace consimd::features::detail {

/// Numbers the cubes of one side over a cloud. There is a layer of empty cubes before the first and behind the last
/// along each axis, so that a neighbour's number never is that of a cube in another row.
class CellKeys {
 public:
  /// `side` in the caller's unit; `name` for errors. Throws std::invalid_argument unless it is finite and > 0, or where
  /// the cloud is more than 2^20 cubes long.
  CellKeys(const Cloud& cloud, double side, const char* name);

  [[nodiscard]] std::uint64_t operator()(std::size_t row) const noexcept {
    std::uint64_t key = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double place = (static_cast<double>(points_[c][row]) - low_[c]) * per_length_;
      key += strides_[c] * (static_cast<std::uint64_t>(place) + 1);
    }
    return key;
  }

  /// The cloud's lowest coordinates and the cubes per unit of length, working frame.
  [[nodiscard]] const std::array<double, 3>& low() const noexcept { return low_; }
  [[nodiscard]] double per_length() const noexcept { return per_length_; }
  /// What is added to a key to come to the next cube along an axis.
  [[nodiscard]] const std::array<std::uint64_t, 3>& strides() const noexcept { return strides_; }

 private:
  std::array<const float*, 3> points_{};
  std::array<double, 3> low_{};
  std::array<std::uint64_t, 3> strides_{};
  double per_length_ = 0.0;
};

/// The order that sorts the keys; equal ones keep theirs.
[[nodiscard]] std::vector<std::uint32_t> sorting_order(const std::vector<std::uint64_t>& keys);

}  // namespace consimd::features::detail
