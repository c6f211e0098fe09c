// Rows in a random order, and a window of them that seeds are tested against.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>

#include "sampling/counter_random.hpp"

namespace consimd::detail {

class SeedWindow {
 public:
  /// Keeps a reference to the correspondences.
  SeedWindow(const Correspondences& correspondences, std::uint64_t seed);

  /// Makes this the `size` rows from place `begin` of the order on, or the last ones, unless it has that size and holds
  /// the places up to `end` already.
  void move(std::uint32_t begin, std::uint32_t end, std::size_t size);

  /// Rows of the window, in the working frame of all.
  [[nodiscard]] const Correspondences& rows() const noexcept { return window_; }
  [[nodiscard]] std::size_t size() const noexcept { return window_.size(); }
  /// Place of the window's first row in the order.
  [[nodiscard]] std::uint32_t first() const noexcept { return first_; }
  /// Row of all that is row `i` of the window.
  [[nodiscard]] std::uint32_t row(std::uint32_t i) const { return order_[first_ + i]; }
  /// Share of all rows that it holds.
  [[nodiscard]] double share() const;

 private:
  const Correspondences& correspondences_;
  CounterRandom random_;              // shuffles
  std::vector<std::uint32_t> order_;  // a random permutation of all rows, final up to shuffled_
  std::uint32_t shuffled_ = 0;
  std::uint32_t first_ = 0;
  Correspondences window_;
};

}  // namespace consimd::detail
