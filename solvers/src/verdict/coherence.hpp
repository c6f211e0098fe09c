// How far outliers move as one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <consimd/kernels/correspondences.hpp>
#include <consimd/kernels/kernel_data.hpp>

namespace consimd::detail {

/// Pairs of correspondences with close sources, and whether their targets are as far apart.
class Coherence {
 public:
  /// Keeps the view. `noise_bound`: caller's unit.
  Coherence(const CorrespondenceView& view, double noise_bound);

  /// Distance up to which outliers move as one: from there on, two correspondences that are no supporters of the pose
  /// have targets as far apart as their sources hardly more often than chance has it. Between `least` and `most`. All
  /// in noise bounds.
  [[nodiscard]] double length(const WorkingPose& pose, double least, double most) const;

 private:
  static constexpr std::size_t kSteps = 7;

  struct Pair {
    std::uint32_t row;
    std::uint32_t other;
    std::uint8_t step;  // of the sources' distance
    bool agrees;
  };

  CorrespondenceView view_;
  double noise_bound_;
  std::vector<Pair> pairs_;
  std::array<double, kSteps> by_chance_{};  // share of pairs whose targets are about as far apart as the step is
};

/// Whether supporters of the pose lie on two parallel lines, one or two strays aside, whose rows come into place
/// together: of two rows on a line along theirs that are no supporters, farther apart than `radius`, the targets are as
/// far apart as the sources far more often than those of any two. Of many rows some are looked at. noise_bound, radius:
/// caller's unit.
[[nodiscard]] bool are_on_two_coherent_lines(const CorrespondenceView& view, const WorkingPose& pose,
                                             double noise_bound, double radius);

}  // namespace consimd::detail
