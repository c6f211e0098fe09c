// Each source point and the target point nearest to it, while the source moves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <consimd/features/cell_grid.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "grid/neighbourhoods.hpp"

namespace consimd::features::detail {

/// Points that one task takes, and that sums are taken over before they are joined: a constant, so that bits do not
/// depend on the threads.
inline constexpr std::size_t kPairBlock = 512;

class ClosestPairs {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// max_distance: caller's unit, below the target's cell.
  ClosestPairs(const Cloud& source, const CellGrid& target, double max_distance, const RigidTransform& start);

  /// Moves the source and finds its pairs. A search is left out where the point has moved by less than half of what the
  /// second nearest point was further away than the nearest: by the triangle inequality it is the nearest still.
  /// `stride`: only every so many entries are moved and paired; the others are no pairs if they never were.
  void move(const RigidTransform& T_target_source, std::size_t stride = 1);

  [[nodiscard]] std::size_t size() const noexcept { return rows_.size(); }
  /// Row of the source that entry i is: entries that follow one another are neighbours.
  [[nodiscard]] std::uint32_t source_row(std::size_t i) const noexcept { return rows_[i]; }
  /// Row of the target that is nearest, kNone where none is within max_distance.
  [[nodiscard]] std::uint32_t target_row(std::size_t i) const noexcept { return pairs_[i]; }
  /// The moved source point, working frame of the target.
  [[nodiscard]] Eigen::Vector3d moved(std::size_t i) const {
    return {static_cast<double>(points_[i][0]), static_cast<double>(points_[i][1]), static_cast<double>(points_[i][2])};
  }

 private:
  /// What the last search around a point told.
  struct Found {
    std::array<float, 3> at;
    std::uint32_t row = kNone;
    float still = -1.0f;  ///< the nearest stays the nearest within this distance of `at`
    float none = -1.0f;   ///< no point is within max_distance within this distance of `at`

    /// Whether there was a search: one that finds nothing reaches further than pairs do.
    [[nodiscard]] bool is_known() const noexcept { return row != kNone || none >= 0.0f; }
  };

  /// `guess`: a row that may be near, or kNone; `gone`: how far the point has come since it was last looked for.
  [[nodiscard]] Found search(CellWalk& walk, const std::array<float, 3>& point, std::uint32_t guess, float gone) const;

  const CellGrid& target_;
  double source_scale_;
  Eigen::Vector3d source_origin_;
  float max_distance_;  // working frame of the target, as what follows
  float reach_;         // of a search
  std::vector<std::uint32_t> rows_;
  std::vector<std::array<float, 3>> sources_;  // working frame of the source
  std::vector<std::array<float, 3>> points_;
  std::vector<Found> found_;
  std::vector<std::uint32_t> pairs_;
};

}  // namespace consimd::features::detail
