#pragma once

#include "../simd.hpp"
#include "cloud_kernels.hpp"
#include "match_tile-inl.hpp"

namespace consimd::detail {

/// Groups of queries against tiles of targets: first each with the one that is most like it, so that lists are good,
/// then with all that are near enough for one of them.
template <typename Arch>
class MatchSearch {
 public:
  MatchSearch(const RawDescriptors& queries, const QueryGroups& groups, const RawDescriptors& targets, std::size_t k,
              const RawMatches& of_queries, const RawMatches& of_targets, const MatchScratch& scratch)
      : queries_(queries),
        targets_(targets),
        groups_(groups),
        tiles_((targets.size + kTileSize - 1) / kTileSize),
        farthest_of_queries_(of_queries.distances + (k - 1) * of_queries.stride),
        farthest_of_targets_(of_targets.distances + (k - 1) * of_targets.stride),
        scratch_(scratch),
        tile_(queries, targets, k, of_queries, of_targets) {}

  void run() const {
    if (tiles_ == 0) return;
    for (std::size_t g = 0; g < groups_.count; ++g) find_box(g);
    find_most_alike();
    for (std::size_t g = 0; g < groups_.count; ++g) visit(g, static_cast<std::size_t>(scratch_.tiles_of_groups[g]));
    for (std::size_t t = 0; t < tiles_; ++t) {
      const auto g = static_cast<std::size_t>(scratch_.groups_of_tiles[t]);
      if (g < groups_.count && scratch_.tiles_of_groups[g] != static_cast<std::int32_t>(t)) visit(g, t);
    }
    for (std::size_t t = 0; t < tiles_; t += kRun) visit_near(t);
  }

 private:
  // Tiles that the first-level cache holds, with their lists, of some 33 components.
  static constexpr std::size_t kRun = kWidth<Arch> < 8 ? 8 : kWidth<Arch>;

  [[nodiscard]] std::int32_t* box(std::size_t g) const { return scratch_.boxes + 2 * kBoxed * g; }
  [[nodiscard]] std::size_t first_row(std::size_t g) const { return groups_.first + g * groups_.step; }
  [[nodiscard]] std::size_t last_row(std::size_t g) const {
    const std::size_t first = first_row(g);
    return queries_.size - first < kQueryGroup ? queries_.size : first + kQueryGroup;
  }

  void find_box(std::size_t g) const {
    std::int32_t* const low = box(g);
    std::int32_t* const high = low + kBoxed;
    const std::size_t length = 2 * queries_.pairs;
    for (std::size_t c = 0; c < kBoxed; ++c) {
      low[c] = high[c] = c < length ? queries_.rows[first_row(g) * length + c] : 0;
      if (c >= length) continue;
      for (std::size_t i = first_row(g) + 1; i < last_row(g); ++i) {
        const std::int32_t x = queries_.rows[i * length + c];
        low[c] = x < low[c] ? x : low[c];
        high[c] = x > high[c] ? x : high[c];
      }
    }
  }

  /// Finds the tile that is most like each group, and the group that is most like each tile: the sum of the differences
  /// between the centres of their boxes is least. What is found only orders the search.
  void find_most_alike() const {
    for (std::size_t t = 0; t < targets_.box_stride; ++t) {
      scratch_.distances_of_tiles[t] = kFarthest;
      scratch_.groups_of_tiles[t] = 0;
    }
    for (std::size_t g = 0; g < groups_.count; ++g) {
      const std::int32_t* const low = box(g);
      const IntBatch<Arch> group(static_cast<std::int32_t>(g));
      IntBatch<Arch> least(kFarthest);
      IntBatch<Arch> tile_of_least(0);
      for (std::size_t t = 0; t < tiles_; t += kWidth<Arch>) {
        IntBatch<Arch> distance(0);
        for (std::size_t c = 0; c < kBoxed; ++c) {
          const std::size_t at = c * targets_.box_stride + t;
          const IntBatch<Arch> twice(low[c] + low[kBoxed + c]);
          distance += xsimd::abs(load(targets_.lows + at) + load(targets_.highs + at) - twice);
        }
        const IntBatch<Arch> of_tiles = load(scratch_.distances_of_tiles + t);
        const IntMask<Arch> nearer = distance < of_tiles;
        xsimd::select(nearer, distance, of_tiles).store_aligned(scratch_.distances_of_tiles + t);
        xsimd::select(nearer, group, load(scratch_.groups_of_tiles + t)).store_aligned(scratch_.groups_of_tiles + t);
        const IntMask<Arch> nearest = distance < least;
        least = xsimd::select(nearest, distance, least);
        tile_of_least = xsimd::select(nearest, IntBatch<Arch>(static_cast<std::int32_t>(t)), tile_of_least);
      }
      scratch_.tiles_of_groups[g] = nearest_tile(least, tile_of_least);
    }
  }

  /// The tile of the least of the lanes; tile + l in lane l.
  [[nodiscard]] static std::int32_t nearest_tile(const IntBatch<Arch>& distances, const IntBatch<Arch>& tiles) {
    alignas(64) std::int32_t of[kWidth<Arch>];
    alignas(64) std::int32_t at[kWidth<Arch>];
    distances.store_aligned(of);
    tiles.store_aligned(at);
    std::int32_t least = kFarthest;
    std::int32_t tile = 0;
    for (std::size_t l = 0; l < kWidth<Arch>; ++l) {
      const std::int32_t t = at[l] + static_cast<std::int32_t>(l);
      if (of[l] < least) {
        least = of[l];
        tile = t;
      }
    }
    return tile;
  }

  bool visit(std::size_t g, std::size_t t) const {
    const std::size_t first = first_row(g);
    if (last_row(g) - first == kQueryGroup) return tile_.template match<kQueryGroup>(first, kTileSize * t);
    bool any = false;
    for (std::size_t i = first; i < last_row(g); ++i) any = tile_.template match<1>(i, kTileSize * t) || any;
    return any;
  }

  /// All groups with those of a run of tiles that are near enough and were not visited before.
  void visit_near(std::size_t first) const {
    alignas(64) std::int32_t farthest[kRun];
    for (std::size_t t = 0; t < kRun; ++t) farthest[t] = first + t < tiles_ ? farthest_of_tile(first + t) : -1;
    const std::uint32_t there = tiles_ - first < kRun ? (1U << (tiles_ - first)) - 1 : (1U << kRun) - 1;
    for (std::size_t g = 0; g < groups_.count; ++g) {
      std::uint32_t near = not_far(g, first, farthest) & there;
      const auto own = static_cast<std::size_t>(scratch_.tiles_of_groups[g]) - first;
      if (own < kRun) near &= ~(1U << own);
      for (; near != 0; near &= near - 1) {
        const auto t = static_cast<std::size_t>(__builtin_ctz(near));
        if (visit(g, first + t)) farthest[t] = farthest_of_tile(first + t);
      }
    }
  }

  /// A bit for each of a run of tiles that a query of the group may be near enough for, or one of whose targets may be
  /// for the group, but for those whose most alike group it is.
  [[nodiscard]] std::uint32_t not_far(std::size_t g, std::size_t first, const std::int32_t* farthest) const {
    std::int32_t of_group = farthest_of_queries_[first_row(g)];
    for (std::size_t i = first_row(g) + 1; i < last_row(g); ++i) {
      of_group = farthest_of_queries_[i] > of_group ? farthest_of_queries_[i] : of_group;
    }
    const std::int32_t* const low = box(g);
    const IntBatch<Arch> zero(0);
    std::uint32_t bits = 0;
    for (std::size_t part = 0; part < kRun; part += kWidth<Arch>) {
      IntBatch<Arch> squared(0);
      for (std::size_t c = 0; c < kBoxed; ++c) {
        const std::size_t at = c * targets_.box_stride + first + part;
        const IntBatch<Arch> below = IntBatch<Arch>(low[c]) - load(targets_.highs + at);
        const IntBatch<Arch> above = load(targets_.lows + at) - IntBatch<Arch>(low[kBoxed + c]);
        const IntBatch<Arch> gap = larger(larger(below, above), zero);
        squared += gap * gap;
      }
      const IntMask<Arch> far = squared > larger(load(farthest + part), IntBatch<Arch>(of_group));
      const IntMask<Arch> visited =
          load(scratch_.groups_of_tiles + first + part) == IntBatch<Arch>(static_cast<std::int32_t>(g));
      bits |= static_cast<std::uint32_t>(bitmask(far | visited)) << part;
    }
    return ~bits;
  }

  [[nodiscard]] std::int32_t farthest_of_tile(std::size_t t) const {
    const std::int32_t* of = farthest_of_targets_ + kTileSize * t;
    IntBatch<Arch> most = load(of);
    for (std::size_t l = kWidth<Arch>; l < kTileSize; l += kWidth<Arch>) most = larger(most, load(of + l));
    alignas(64) std::int32_t lanes[kWidth<Arch>];
    most.store_aligned(lanes);
    std::int32_t farthest = lanes[0];
    for (const std::int32_t lane : lanes) farthest = lane > farthest ? lane : farthest;
    return farthest;
  }

  static IntBatch<Arch> load(const std::int32_t* from) { return load_whole<Arch>(from); }

  static constexpr std::int32_t kFarthest = 0x7fffffff;

  RawDescriptors queries_;
  RawDescriptors targets_;
  QueryGroups groups_;
  std::size_t tiles_;
  const std::int32_t* farthest_of_queries_;
  const std::int32_t* farthest_of_targets_;
  MatchScratch scratch_;
  MatchTile<Arch> tile_;
};

template <typename Arch>
void best_matches(const RawDescriptors& queries, const QueryGroups& groups, const RawDescriptors& targets,
                  std::size_t k, const RawMatches& of_queries, const RawMatches& of_targets,
                  const MatchScratch& scratch) {
  MatchSearch<Arch>(queries, groups, targets, k, of_queries, of_targets, scratch).run();
}

}  // namespace consimd::detail
