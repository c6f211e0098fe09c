#include "descriptor_order.hpp"

#include <algorithm>
#include <numeric>

namespace consimd::detail {
namespace {

class Splitter {
 public:
  Splitter(std::span<const std::int16_t> values, std::size_t length, std::size_t leading, std::size_t leaf)
      : values_(values),
        length_(length),
        leading_(std::min(length, leading)),
        leaf_(leaf),
        keys_(values.size() / length) {}

  /// Halves rows where they vary most until a leaf is left. First halves are of whole leaves.
  void split(std::span<std::uint32_t> rows) {
    while (rows.size() > leaf_) {
      const std::size_t component = widest(rows);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        keys_[i] = static_cast<std::uint64_t>(value(rows[i], component) + 0x8000) << 32U | rows[i];
      }
      const std::size_t half = (rows.size() / 2 + leaf_ - 1) / leaf_ * leaf_;
      const auto keys = keys_.begin();
      std::nth_element(keys, keys + static_cast<std::ptrdiff_t>(half), keys + static_cast<std::ptrdiff_t>(rows.size()));
      for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<std::uint32_t>(keys_[i]);
      split(rows.first(half));
      rows = rows.subspan(half);
    }
  }

 private:
  [[nodiscard]] std::int16_t value(std::uint32_t row, std::size_t component) const {
    return values_[row * length_ + component];
  }

  /// The component of the largest variance.
  [[nodiscard]] std::size_t widest(std::span<const std::uint32_t> rows) const {
    std::size_t widest = 0;
    double most = -1.0;
    for (std::size_t component = 0; component < leading_; ++component) {
      std::int64_t sum = 0;
      std::int64_t squared = 0;
      for (const std::uint32_t row : rows) {
        const std::int32_t x = value(row, component);
        sum += x;
        squared += x * x;
      }
      const auto mean = static_cast<double>(sum) / static_cast<double>(rows.size());
      const double variance = static_cast<double>(squared) / static_cast<double>(rows.size()) - mean * mean;
      if (variance > most) {
        most = variance;
        widest = component;
      }
    }
    return widest;
  }

  std::span<const std::int16_t> values_;
  std::size_t length_;
  std::size_t leading_;
  std::size_t leaf_;
  std::vector<std::uint64_t> keys_;  // a value and its row
};

}  // namespace

std::vector<std::uint32_t> alike_together(std::span<const std::int16_t> values, std::size_t length, std::size_t leading,
                                          std::size_t leaf) {
  std::vector<std::uint32_t> rows(values.size() / length);
  std::iota(rows.begin(), rows.end(), 0u);
  Splitter(values, length, leading, leaf).split(rows);
  return rows;
}

}  // namespace consimd::detail
