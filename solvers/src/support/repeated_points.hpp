// Points that are in many rows: landmarks matched with all others, the images of a symmetric part.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// Rows a point from which these are many. The three nearest descriptors of each, which is what matchers give, are not.
inline constexpr double kManyRows = 4.0;

/// Whether the points of one cloud are in so many rows each or more, as far as some pairs of rows from all over tell.
[[nodiscard]] bool one_to_many(const CorrespondenceView& view);

/// The pairs of a source and a target that support a pose, where points are in many rows: in other rows these are no
/// mismatch.
class MatchedPoints {
 public:
  /// Takes the pairs of the rows within `bound` (caller's unit) of the pose; none unless the points of both
  /// clouds are in many rows.
  MatchedPoints(const CorrespondenceView& view, const WorkingPose& pose, double bound);

  [[nodiscard]] bool empty() const noexcept { return pairs_.empty(); }
  /// As given.
  [[nodiscard]] double bound() const noexcept { return bound_; }
  /// Pairs of a source and a target, each point once.
  [[nodiscard]] double different_pairs() const noexcept { return different_pairs_; }
  /// Whether the source of one row and the target of another are such a pair.
  [[nodiscard]] bool contains(const CorrespondenceView& view, std::size_t source_row, std::size_t target_row) const;

 private:
  double bound_;
  double different_pairs_ = 0.0;
  std::vector<std::array<float, 6>> pairs_;  // in order
};

/// Rows, ascending, that have the source or the target of one of `members` and are none of them. members: ascending.
[[nodiscard]] std::vector<std::uint32_t> rows_sharing_a_point(const CorrespondenceView& view,
                                                              std::span<const std::uint32_t> members);

}  // namespace consimd::detail
