#include "grid/cell_keys.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "grid/box.hpp"

namespace consimd::features::detail {
namespace {

constexpr double kMostCells = 1u << 20;

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

}  // namespace

CellKeys::CellKeys(const Cloud& cloud, double side, const char* name) {
  if (!std::isfinite(side) || side <= 0.0) {
    throw std::invalid_argument(std::string(name) + " is " + shown(side) + ", expected a finite length above 0");
  }
  const CloudView view = cloud.view();
  per_length_ = 1.0 / (side * view.scale());
  std::array<std::uint64_t, 3> sizes{};
  const Box box = box_around(cloud);
  for (std::size_t c = 0; c < 3; ++c) {
    points_[c] = view.points(c);
    low_[c] = static_cast<double>(box.low[c]);
    const double length = static_cast<double>(box.high[c]) - low_[c];
    if (!(length * per_length_ < kMostCells)) {
      throw std::invalid_argument(std::string(name) + " is " + shown(side) + " and the cloud " +
                                  shown(length / view.scale()) + " long, expected one above " +
                                  shown(length / view.scale() / kMostCells));
    }
    sizes[c] = static_cast<std::uint64_t>(length * per_length_) + 3;
  }
  strides_ = {1, sizes[0], sizes[0] * sizes[1]};
}

std::vector<std::uint32_t> sorting_order(const std::vector<std::uint64_t>& keys) {
  // From the lowest digit to the highest, each pass keeping the order of the last.
  constexpr unsigned kDigitBits = 11;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  std::vector<std::uint32_t> order(keys.size()), sorted(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  if (keys.empty()) return order;
  const std::uint64_t lowest = *std::min_element(keys.begin(), keys.end());
  const std::uint64_t range = *std::max_element(keys.begin(), keys.end()) - lowest;
  std::vector<std::uint32_t> places(kDigits);
  for (unsigned shift = 0; shift < 64 && range >> shift != 0; shift += kDigitBits) {
    const auto digit = [&](std::uint32_t row) { return (keys[row] - lowest) >> shift & (kDigits - 1); };
    std::fill(places.begin(), places.end(), 0u);
    for (const std::uint32_t row : order) ++places[digit(row)];
    std::exclusive_scan(places.begin(), places.end(), places.begin(), 0u);
    for (const std::uint32_t row : order) sorted[places[digit(row)]++] = row;
    std::swap(order, sorted);
  }
  return order;
}

}  // namespace consimd::features::detail
