// Nearest descriptors among many, exact, in whole numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// How descriptors that are to be compared with each other are written in whole numbers.
class FixedPointForm {
 public:
  /// For two sets of descriptors, rows of `length` numbers each. Throws std::invalid_argument on a length of 0 or above
  /// 4096, on a size that is no multiple of it, and on a value that is not finite (naming its set and descriptor).
  FixedPointForm(std::span<const float> source, std::span<const float> target, std::size_t length);

  [[nodiscard]] std::size_t length() const noexcept { return components_.size(); }
  /// What one stands for: the largest norm takes some 14.5 bits.
  [[nodiscard]] double unit() const noexcept { return unit_; }
  /// The numbers of a row in the order in which they are compared: those that vary most come first, so that most
  /// descriptors are told apart by a few.
  [[nodiscard]] std::span<const std::uint16_t> components() const noexcept { return components_; }

  friend bool operator==(const FixedPointForm&, const FixedPointForm&) = default;

 private:
  double unit_ = 1.0;
  std::vector<std::uint16_t> components_;
};

/// Owner of N descriptors of any length in fixed point: each component is rounded to a multiple of the form's unit.
/// Distances between descriptors of one form are exact whole numbers, so that their order and the ties among them are
/// the same on every instruction set. They are kept in an order of their own, alike ones together.
class FixedPointDescriptors {
 public:
  /// values: N rows of the form's length, N below 2^31. Throws std::invalid_argument on a size that is no multiple of
  /// the length, and on a descriptor that is not finite or too long for the form (naming it).
  FixedPointDescriptors(std::span<const float> values, const FixedPointForm& form);

  [[nodiscard]] std::size_t size() const noexcept { return places_.size(); }
  [[nodiscard]] const FixedPointForm& form() const noexcept { return form_; }

 private:
  friend class BestMatches;
  friend void best_matches(const FixedPointDescriptors&, const FixedPointDescriptors&, class BestMatches&,
                           class BestMatches&, std::size_t, std::size_t);

  struct AlignedDelete {
    void operator()(std::int32_t* p) const noexcept;
  };

  FixedPointForm form_;
  std::vector<std::uint32_t> places_;                    // where each descriptor is kept
  std::unique_ptr<std::int32_t[], AlignedDelete> data_;  // see Parts in kernels/src/clouds/descriptor_matches.cpp
};

/// The k nearest descriptors found so far of each of a number of them.
class BestMatches {
 public:
  /// What a rank that has no match yet refers to.
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// Throws std::invalid_argument unless k is between 1 and 8.
  BestMatches(const FixedPointDescriptors& of, std::size_t k);

  [[nodiscard]] std::size_t size() const noexcept { return places_.size(); }
  [[nodiscard]] std::size_t k() const noexcept { return k_; }
  /// Number of the match of rank `rank` of descriptor i, kNone where there are fewer. Ranks ascend by distance, then by
  /// number.
  [[nodiscard]] std::uint32_t index(std::size_t i, std::size_t rank) const noexcept {
    return numbers()[rank * stride_ + places_[i]];
  }
  /// Squared distance of the match of rank `rank` of descriptor i, in squared units.
  [[nodiscard]] std::int32_t squared_distance(std::size_t i, std::size_t rank) const noexcept {
    return data_[rank * stride_ + places_[i]];
  }

  /// Enters the matches of another, of the same descriptors and k, which has searched among others. Throws
  /// std::invalid_argument on lists of other descriptors or of another k.
  void merge(const BestMatches& other);

 private:
  friend void best_matches(const FixedPointDescriptors&, const FixedPointDescriptors&, BestMatches&, BestMatches&,
                           std::size_t, std::size_t);

  [[nodiscard]] const std::uint32_t* numbers() const noexcept {
    return reinterpret_cast<const std::uint32_t*>(data_.get() + k_ * stride_);
  }

  std::vector<std::uint32_t> places_;
  std::size_t k_;
  std::size_t stride_;
  // Rank by rank: squared distances, then numbers, in the order in which the descriptors are kept.
  std::unique_ptr<std::int32_t[], FixedPointDescriptors::AlignedDelete> data_;
};

/// Enters the squared distances between one of `parts` parts of the queries and all targets into the best matches of
/// both: as if all were computed, though most pairs of alike structure are told too far apart by their first components
/// or by the boxes that alike descriptors lie in. Parts may come in any order, each once. They may also run at the same
/// time with the same `of_queries`, each with an `of_targets` of its own, which are merged then. Throws
/// std::invalid_argument on descriptors of different form, on lists of other descriptors or of different k,
/// std::out_of_range unless part < parts.
void best_matches(const FixedPointDescriptors& queries, const FixedPointDescriptors& targets, BestMatches& of_queries,
                  BestMatches& of_targets, std::size_t part = 0, std::size_t parts = 1);

}  // namespace consimd
