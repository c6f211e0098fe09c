// Nearest descriptors among many, by brute force in whole numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Owner of N descriptors of any length in fixed point: each component is rounded to a multiple of `unit`.
/// Distances between descriptors of one unit are exact whole numbers, so that their order and the ties among them are
/// the same on every instruction set. The largest norm takes some 14.5 bits.
class FixedPointDescriptors {
 public:
  FixedPointDescriptors() = default;

  /// values: N rows of `length` numbers. `unit` as `unit_for` gives it for the largest norm of all descriptors that are
  /// to be compared. Throws std::invalid_argument on a size that is no multiple of the length, a length of 0 or above
  /// 4096, a value that is not finite (naming its row), a bad unit, or a norm that is too large for the unit.
  FixedPointDescriptors(std::span<const float> values, std::size_t length, double unit);

  /// The finest unit for descriptors whose norms are at most `largest_norm`, finite and >= 0.
  [[nodiscard]] static double unit_for(double largest_norm, std::size_t length);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t length() const noexcept { return length_; }
  [[nodiscard]] double unit() const noexcept { return unit_; }

 private:
  friend void best_matches(const FixedPointDescriptors&, std::size_t, std::size_t, const FixedPointDescriptors&,
                           class BestMatches&, class BestMatches&);

  struct AlignedDelete {
    void operator()(std::int16_t* p) const noexcept;
  };

  std::unique_ptr<std::int16_t[], AlignedDelete> data_;  // squared norms, tiles, rows: see kernels/src/clouds
  std::size_t size_ = 0;
  std::size_t length_ = 0;
  std::size_t pairs_ = 0;
  double unit_ = 1.0;
};

/// The k nearest descriptors found so far of each of `size` ones.
class BestMatches {
 public:
  /// What a rank that has no match yet refers to.
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// Throws std::invalid_argument unless k is between 1 and 8.
  BestMatches(std::size_t size, std::size_t k);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t k() const noexcept { return k_; }
  /// Index of the match of rank `rank`, kNone where there are fewer. Ranks ascend by distance, then by index.
  [[nodiscard]] std::uint32_t index(std::size_t i, std::size_t rank) const noexcept {
    return indices()[rank * stride_ + i];
  }
  /// Squared distance of the match of rank `rank`, in squared units.
  [[nodiscard]] std::int32_t squared_distance(std::size_t i, std::size_t rank) const noexcept {
    return distances()[rank * stride_ + i];
  }

  /// Enters the matches of another, of the same size and k, which has searched among others. Throws
  /// std::invalid_argument on other sizes.
  void merge(const BestMatches& other);

 private:
  friend void best_matches(const FixedPointDescriptors&, std::size_t, std::size_t, const FixedPointDescriptors&,
                           BestMatches&, BestMatches&);
  struct AlignedDelete {
    void operator()(std::int32_t* p) const noexcept;
  };
  [[nodiscard]] const std::int32_t* distances() const noexcept { return data_.get(); }
  [[nodiscard]] const std::uint32_t* indices() const noexcept {
    return reinterpret_cast<const std::uint32_t*>(data_.get() + k_ * stride_);
  }

  std::unique_ptr<std::int32_t[], AlignedDelete> data_;  // rank by rank: squared distances, then indices
  std::size_t size_;
  std::size_t k_;
  std::size_t stride_;
};

/// Enters the squared distances between queries first to last - 1 and all targets into the best matches of both. One
/// pass serves both; distances are never stored. Calls must come with ascending queries, each in one call, so that of
/// equally near ones the lower index is kept. Throws std::invalid_argument on descriptors of different length or unit,
/// on lists of other sizes than the descriptors, or of different k, std::out_of_range where first <= last <=
/// queries.size() does not hold.
void best_matches(const FixedPointDescriptors& queries, std::size_t first, std::size_t last,
                  const FixedPointDescriptors& targets, BestMatches& of_queries, BestMatches& of_targets);

}  // namespace consimd
