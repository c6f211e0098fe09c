// Each source point and the target point nearest to it, while the source moves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/pair_block.hpp>
#include <consimd/poses/rigid_fit.hpp>

#include "grid/neighbourhoods.hpp"

namespace consimd::features::detail {

/// The source's rows by the cells of the target into which a pose takes them: those that follow one another are
/// neighbours in the target as well.
[[nodiscard]] std::vector<std::uint32_t> rows_by_target_cell(const Cloud& source, const CellGrid& target,
                                                             const RigidTransform& pose);

class ClosestPairs {
 public:
  /// rows: of the source, best such that neighbours follow one another. max_distance: points further apart are no pair;
  /// reach: how far to look for what is nearest, above max_distance, at most the target's cell; caller's unit.
  ClosestPairs(const Cloud& source, std::span<const std::uint32_t> rows, const CellGrid& target, double max_distance,
               double reach);

  /// Moves the source and finds its nearest points. A search is left out where the point has moved by less than half of
  /// what the second nearest point was further away than the nearest: by the triangle inequality it is the nearest
  /// still.
  void move(const RigidTransform& T_target_source);

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Entries in blocks, what sums are taken over before they are joined: bits do not depend on the threads.
  [[nodiscard]] std::size_t blocks() const noexcept { return blocks_.size(); }
  [[nodiscard]] const PairBlock& block(std::size_t b) const noexcept { return blocks_[b]; }
  /// Entries of a block.
  [[nodiscard]] std::size_t entries(std::size_t b) const noexcept {
    return std::min(PairBlock::kSize, size_ - b * PairBlock::kSize);
  }
  /// Working frame of the target.
  [[nodiscard]] float max_distance() const noexcept { return max_distance_; }

 private:
  /// Looks for what is nearest to a block's entry. `guess`: a row that may be near, or target's size.
  void search(CellWalk& walk, PairBlock& block, std::size_t entry, std::uint32_t guess) const;

  const CellGrid& target_;
  std::size_t size_;
  double source_scale_;
  Eigen::Vector3d source_origin_;
  float max_distance_;  // working frame of the target, as what follows
  float reach_;         // of a search
  std::vector<PairBlock> blocks_;
};

}  // namespace consimd::features::detail
