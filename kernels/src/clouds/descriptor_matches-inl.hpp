#pragma once

#include <utility>

#include "../simd.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail {

/// A query's list of best matches while some are entered: keys of distance and number, which ascend as the ranks do.
template <typename Arch>
class QueryList {
 public:
  QueryList(const RawMatches& best, std::size_t k, std::size_t i) : best_(best), k_(k), i_(i) {
    for (std::size_t rank = 0; rank < k; ++rank) {
      const std::size_t at = rank * best.stride + i;
      keys_[rank] = key(best.distances[at], best.numbers[at]);
    }
  }

  /// The match falls through the ranks and is exchanged for each that comes behind it: no branch, which could not be
  /// foreseen.
  void enter(std::int32_t distance, std::int32_t number) {
    std::uint64_t falling = key(distance, number);
    for (std::size_t rank = 0; rank < k_; ++rank) {
      const std::uint64_t here = keys_[rank];
      keys_[rank] = here < falling ? here : falling;
      falling = here < falling ? falling : here;
    }
  }

  void store() const {
    for (std::size_t rank = 0; rank < k_; ++rank) {
      const std::size_t at = rank * best_.stride + i_;
      best_.distances[at] = static_cast<std::int32_t>(keys_[rank] >> 32U);
      best_.numbers[at] = static_cast<std::int32_t>(keys_[rank]);
    }
  }

 private:
  static std::uint64_t key(std::int32_t distance, std::int32_t number) {
    return std::uint64_t{static_cast<std::uint32_t>(distance)} << 32U | static_cast<std::uint32_t>(number);
  }

  const RawMatches& best_;
  std::size_t k_;
  std::size_t i_;
  std::uint64_t keys_[kMostMatches];
};

template <typename Arch>
inline IntBatch<Arch> load_whole(const std::int32_t* from) {
  return IntBatch<Arch>::load_aligned(from);
}

template <typename Arch>
class MatchTile {
 public:
  MatchTile(const RawDescriptors& queries, const RawDescriptors& targets, std::size_t k, const RawMatches& of_queries,
            const RawMatches& of_targets)
      : queries_(queries), targets_(targets), k_(k), of_queries_(of_queries), of_targets_(of_targets) {}

  /// Queries i .. i + kRows - 1 against the tile that begins with target j. Returns whether any is near enough for a
  /// list.
  template <std::size_t kRows>
  bool match(std::size_t i, std::size_t j) const {
    bool any = false;
    for (std::size_t part = 0; part < kTileSize; part += kSpan) any = match_span<kRows>(i, j, part) || any;
    return any;
  }

 private:
  // Accumulators of four queries and two registers of targets fit into 16 registers.
  static constexpr std::size_t kRegisters = kWidth<Arch> == kTileSize ? 1 : 2;
  static constexpr std::size_t kSpan = kRegisters * kWidth<Arch>;
  static constexpr std::uint64_t kAll = (std::uint64_t{1} << kWidth<Arch>)-1;
  using Span = IntBatch<Arch>[kRegisters];

  template <std::size_t kRows>
  bool match_span(std::size_t i, std::size_t j, std::size_t part) const {
    const std::size_t pairs = queries_.pairs;
    const std::size_t leading = pairs < kLeadingPairs ? pairs : kLeadingPairs;
    const std::int16_t* tile = targets_.tiles + 2 * (j * pairs + part);
    const std::int16_t* rows = queries_.rows + 2 * i * pairs;
    Span products[kRows];
    for (auto& row : products) {
      for (auto& sum : row) sum = IntBatch<Arch>(0);
    }
    for (std::size_t c = 0; c < leading; ++c) {
      Span target;
      for (std::size_t r = 0; r < kRegisters; ++r) target[r] = load_pairs(tile, c, r);
      for (std::size_t q = 0; q < kRows; ++q) {
        const IntBatch<Arch> query = broadcast_pair(rows + 2 * (q * pairs + c));
        for (std::size_t r = 0; r < kRegisters; ++r) {
          products[q][r] = sum_in_place(products[q][r], pair_products(target[r], query));
        }
      }
    }
    // No loop: a register with a number that is known only at run time would live in memory, in the loop above as well.
    std::uint32_t near = 0;
    [&]<std::size_t... kRow>(std::index_sequence<kRow...>) {
      ((near |=
        are_far(i + kRow, j + part, products[kRow], queries_.leading_norms, targets_.leading_norms) ? 0u : 1u << kRow),
       ...);
    }
    (std::make_index_sequence<kRows>());
    if (near == 0) return false;
    alignas(64) std::int32_t leading_products[kRows][kSpan];
    for (std::size_t q = 0; q < kRows; ++q) {
      for (std::size_t r = 0; r < kRegisters; ++r) {
        products[q][r].store_aligned(leading_products[q] + r * kWidth<Arch>);
      }
    }
    bool any = false;
    for (; near != 0; near &= near - 1) {
      const auto q = static_cast<std::size_t>(__builtin_ctz(near));
      any = finish(i + q, j, part, leading_products[q]) || any;
    }
    return any;
  }

  /// Enters query i into the lists of the targets from j + part on, and these into its own, where one is near enough.
  bool finish(std::size_t i, std::size_t j, std::size_t part, std::int32_t* leading_products) const {
    const std::size_t pairs = queries_.pairs;
    const std::int16_t* tile = targets_.tiles + 2 * (j * pairs + part);
    const std::int16_t* row = queries_.rows + 2 * i * pairs;
    Span products;
    for (std::size_t r = 0; r < kRegisters; ++r) products[r] = load(leading_products + r * kWidth<Arch>);
    for (std::size_t c = kLeadingPairs; c < pairs; ++c) {
      const IntBatch<Arch> query = broadcast_pair(row + 2 * c);
      for (std::size_t r = 0; r < kRegisters; ++r) {
        products[r] = sum_in_place(products[r], pair_products(load_pairs(tile, c, r), query));
      }
    }
    if (are_far(i, j + part, products, queries_.squared_norms, targets_.squared_norms)) return false;
    const IntBatch<Arch> norm(queries_.squared_norms[i]);
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const std::size_t at = r * kWidth<Arch>;
      const IntBatch<Arch> distance = load(targets_.squared_norms + j + part + at) - (products[r] + products[r]) + norm;
      distance.store_aligned(leading_products + at);
    }
    enter(i, j + part, leading_products);
    return true;
  }

  /// Tells whether query i is too far from all targets from j on for a list of either, by products and squared norms
  /// of all components or of the leading ones alone.
  bool are_far(std::size_t i, std::size_t j, const Span& products, const std::int32_t* norms_of_queries,
               const std::int32_t* norms_of_targets) const {
    const std::size_t last = k_ - 1;
    const IntBatch<Arch> limit_of_query(of_queries_.distances[last * of_queries_.stride + i]);
    const IntBatch<Arch> norm_of_query(norms_of_queries[i]);
    IntMask<Arch> far(true);
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const std::size_t at = j + r * kWidth<Arch>;
      const IntBatch<Arch> limit_of_targets = load(of_targets_.distances + last * of_targets_.stride + at);
      const IntBatch<Arch> limit = xsimd::max(limit_of_query, limit_of_targets) - norm_of_query;
      far = far & (load(norms_of_targets + at) - (products[r] + products[r]) > limit);
    }
    return bitmask(far) == kAll;
  }

  /// Enters the distances of query i to the targets from j on into the lists of both.
  [[gnu::noinline]] void enter(std::size_t i, std::size_t j, const std::int32_t* distances) const {
    const IntBatch<Arch> limit(of_queries_.distances[(k_ - 1) * of_queries_.stride + i]);
    const IntBatch<Arch> number(queries_.numbers[i]);
    std::uint64_t near = 0;
    for (std::size_t part = 0; part < kSpan; part += kWidth<Arch>) {
      const IntBatch<Arch> these = load(distances + part);
      enter_query(j + part, these, number);
      near |= (bitmask(these > limit) ^ kAll) << part;
    }
    const std::size_t there = j < targets_.size ? targets_.size - j : 0;
    if (there < kSpan) near &= (std::uint64_t{1} << there) - 1;
    if (near == 0) return;
    QueryList<Arch> list(of_queries_, k_, i);
    for (; near != 0; near &= near - 1) {
      const auto l = static_cast<std::size_t>(__builtin_ctzll(near));
      list.enter(distances[l], targets_.numbers[j + l]);
    }
    list.store();
  }

  /// Enters a query into the lists of the targets from j on, as many as a register holds: from the last rank on each
  /// takes what was above it, the query, or what it had.
  void enter_query(std::size_t j, const IntBatch<Arch>& distance, const IntBatch<Arch>& query) const {
    std::int32_t* distances = of_targets_.distances + j;
    std::int32_t* numbers = of_targets_.numbers + j;
    const auto comes_before = [&](const IntBatch<Arch>& other, const IntBatch<Arch>& its_number) {
      return (distance < other) | ((distance == other) & (query < its_number));
    };
    std::size_t here = (k_ - 1) * of_targets_.stride;
    IntBatch<Arch> had = load(distances + here);
    IntBatch<Arch> had_number = load(numbers + here);
    IntMask<Arch> enters = comes_before(had, had_number);
    for (; here > 0; here -= of_targets_.stride) {
      const std::size_t above = here - of_targets_.stride;
      const IntBatch<Arch> next = load(distances + above);
      const IntBatch<Arch> next_number = load(numbers + above);
      const IntMask<Arch> falls = comes_before(next, next_number);
      xsimd::select(falls, next, xsimd::select(enters, distance, had)).store_aligned(distances + here);
      xsimd::select(falls, next_number, xsimd::select(enters, query, had_number)).store_aligned(numbers + here);
      had = next;
      had_number = next_number;
      enters = falls;
    }
    xsimd::select(enters, distance, had).store_aligned(distances);
    xsimd::select(enters, query, had_number).store_aligned(numbers);
  }

  static IntBatch<Arch> load(const std::int32_t* from) { return load_whole<Arch>(from); }

  /// Components 2c and 2c + 1 of a register of targets.
  static IntBatch<Arch> load_pairs(const std::int16_t* tile, std::size_t c, std::size_t r) {
    return load(reinterpret_cast<const std::int32_t*>(tile + 2 * (kTileSize * c + r * kWidth<Arch>)));
  }

  static IntBatch<Arch> broadcast_pair(const std::int16_t* pair) {
    std::int32_t both = 0;
    __builtin_memcpy(&both, pair, sizeof(both));
    return IntBatch<Arch>(both);
  }

  // Copies, which no store through a list can change: they stay in registers.
  RawDescriptors queries_;
  RawDescriptors targets_;
  std::size_t k_;
  RawMatches of_queries_;
  RawMatches of_targets_;
};

/// Groups of queries against tiles of targets: first each with the one that is most like it, so that lists are good,
/// then with all that are near enough for one of them.
template <typename Arch>
class MatchSearch {
 public:
  MatchSearch(const RawDescriptors& queries, const QueryPart& part, const RawDescriptors& targets, std::size_t k,
              const RawMatches& of_queries, const RawMatches& of_targets, const MatchScratch& scratch)
      : queries_(queries),
        targets_(targets),
        part_(part),
        groups_(part.groups(queries.size)),
        tiles_((targets.size + kTileSize - 1) / kTileSize),
        farthest_of_queries_(of_queries.distances + (k - 1) * of_queries.stride),
        farthest_of_targets_(of_targets.distances + (k - 1) * of_targets.stride),
        scratch_(scratch),
        tile_(queries, targets, k, of_queries, of_targets) {}

  void run() const {
    if (tiles_ == 0) return;
    for (std::size_t g = 0; g < groups_; ++g) find_box(g);
    find_most_alike();
    for (std::size_t g = 0; g < groups_; ++g) visit(g, static_cast<std::size_t>(scratch_.tiles_of_groups[g]));
    for (std::size_t t = 0; t < tiles_; ++t) {
      const auto g = static_cast<std::size_t>(scratch_.groups_of_tiles[t]);
      if (g < groups_ && scratch_.tiles_of_groups[g] != static_cast<std::int32_t>(t)) visit(g, t);
    }
    for (std::size_t t = 0; t < tiles_; t += kRun) visit_near(t);
  }

 private:
  // Tiles that the first-level cache holds, with their lists.
  static constexpr std::size_t kRun = kWidth<Arch> < 8 ? 8 : kWidth<Arch>;

  [[nodiscard]] std::int32_t* box(std::size_t g) const { return scratch_.boxes + 2 * kBoxed * g; }
  [[nodiscard]] std::size_t last_row(std::size_t g) const {
    const std::size_t first = part_.first(g);
    return queries_.size - first < kQueryGroup ? queries_.size : first + kQueryGroup;
  }

  void find_box(std::size_t g) const {
    std::int32_t* const low = box(g);
    std::int32_t* const high = low + kBoxed;
    const std::size_t length = 2 * queries_.pairs;
    for (std::size_t c = 0; c < kBoxed; ++c) {
      low[c] = high[c] = c < length ? queries_.rows[part_.first(g) * length + c] : 0;
      if (c >= length) continue;
      for (std::size_t i = part_.first(g) + 1; i < last_row(g); ++i) {
        const std::int32_t x = queries_.rows[i * length + c];
        low[c] = x < low[c] ? x : low[c];
        high[c] = x > high[c] ? x : high[c];
      }
    }
  }

  /// Of each group the tile, and of each tile the group, between the centres of whose boxes the sum of the components'
  /// differences is least. What is found only orders the search.
  void find_most_alike() const {
    for (std::size_t t = 0; t < targets_.box_stride; ++t) {
      scratch_.distances_of_tiles[t] = kFarthest;
      scratch_.groups_of_tiles[t] = 0;
    }
    for (std::size_t g = 0; g < groups_; ++g) {
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

  /// The tile of the least of the lanes; tile + l in lane l. Boxes behind the last tile are no tile's.
  [[nodiscard]] std::int32_t nearest_tile(const IntBatch<Arch>& distances, const IntBatch<Arch>& tiles) const {
    alignas(64) std::int32_t of[kWidth<Arch>];
    alignas(64) std::int32_t at[kWidth<Arch>];
    distances.store_aligned(of);
    tiles.store_aligned(at);
    std::int32_t least = kFarthest;
    std::int32_t tile = 0;
    for (std::size_t l = 0; l < kWidth<Arch>; ++l) {
      const std::int32_t t = at[l] + static_cast<std::int32_t>(l);
      if (of[l] < least && t < static_cast<std::int32_t>(tiles_)) {
        least = of[l];
        tile = t;
      }
    }
    return tile;
  }

  bool visit(std::size_t g, std::size_t t) const {
    const std::size_t first = part_.first(g);
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
    for (std::size_t g = 0; g < groups_; ++g) {
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
    std::int32_t of_group = farthest_of_queries_[part_.first(g)];
    for (std::size_t i = part_.first(g) + 1; i < last_row(g); ++i) {
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
        const IntBatch<Arch> gap = xsimd::max(xsimd::max(below, above), zero);
        squared += gap * gap;
      }
      const IntMask<Arch> far = squared > xsimd::max(load(farthest + part), IntBatch<Arch>(of_group));
      const IntMask<Arch> visited =
          load(scratch_.groups_of_tiles + first + part) == IntBatch<Arch>(static_cast<std::int32_t>(g));
      bits |= static_cast<std::uint32_t>(bitmask(far | visited)) << part;
    }
    return ~bits;
  }

  [[nodiscard]] std::int32_t farthest_of_tile(std::size_t t) const {
    const std::int32_t* of = farthest_of_targets_ + kTileSize * t;
    IntBatch<Arch> most = load(of);
    for (std::size_t l = kWidth<Arch>; l < kTileSize; l += kWidth<Arch>) most = xsimd::max(most, load(of + l));
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
  QueryPart part_;
  std::size_t groups_;
  std::size_t tiles_;
  const std::int32_t* farthest_of_queries_;
  const std::int32_t* farthest_of_targets_;
  MatchScratch scratch_;
  MatchTile<Arch> tile_;
};

template <typename Arch>
void best_matches(const RawDescriptors& queries, const QueryPart& part, const RawDescriptors& targets, std::size_t k,
                  const RawMatches& of_queries, const RawMatches& of_targets, const MatchScratch& scratch) {
  MatchSearch<Arch>(queries, part, targets, k, of_queries, of_targets, scratch).run();
}

}  // namespace consimd::detail
