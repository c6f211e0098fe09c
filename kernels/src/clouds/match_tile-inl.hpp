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
    return enter(i, j + part, leading_products);
  }

  static IntMask<Arch> comes_before(const IntBatch<Arch>& distance, const IntBatch<Arch>& number,
                                    const IntBatch<Arch>& other, const IntBatch<Arch>& its_number) {
    return (distance < other) | ((distance == other) & (number < its_number));
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
      const IntBatch<Arch> limit = larger(limit_of_query, limit_of_targets) - norm_of_query;
      far = far & (load(norms_of_targets + at) - (products[r] + products[r]) > limit);
    }
    return bitmask(far) == kAll;
  }

  /// Enters query i into the lists of the targets from j on, and these into its own, where they come before its last.
  /// Returns whether any does.
  [[gnu::noinline]] bool enter(std::size_t i, std::size_t j, const std::int32_t* distances) const {
    const std::size_t last = k_ - 1;
    const IntBatch<Arch> farthest(of_queries_.distances[last * of_queries_.stride + i]);
    const IntBatch<Arch> number_of_farthest(of_queries_.numbers[last * of_queries_.stride + i]);
    const IntBatch<Arch> number(queries_.numbers[i]);
    std::uint64_t for_query = 0;
    bool any = false;
    for (std::size_t l = 0; l < kSpan; l += kWidth<Arch>) {
      const IntBatch<Arch> these = load(distances + l);
      for_query |= bitmask(comes_before(these, load(targets_.numbers + j + l), farthest, number_of_farthest)) << l;
      const std::size_t at = last * of_targets_.stride + j + l;
      if (bitmask(comes_before(these, number, load(of_targets_.distances + at), load(of_targets_.numbers + at))) == 0) {
        continue;
      }
      enter_query(j + l, these, number);
      any = true;
    }
    const std::size_t there = j < targets_.size ? targets_.size - j : 0;
    if (there < kSpan) for_query &= (std::uint64_t{1} << there) - 1;
    if (for_query == 0) return any;
    QueryList<Arch> list(of_queries_, k_, i);
    for (; for_query != 0; for_query &= for_query - 1) {
      const auto l = static_cast<std::size_t>(__builtin_ctzll(for_query));
      list.enter(distances[l], targets_.numbers[j + l]);
    }
    list.store();
    return true;
  }

  /// Enters a query into the lists of the targets from j on, as many as a register holds: from the last rank on each
  /// takes what was above it, the query, or what it had.
  void enter_query(std::size_t j, const IntBatch<Arch>& distance, const IntBatch<Arch>& query) const {
    std::int32_t* distances = of_targets_.distances + j;
    std::int32_t* numbers = of_targets_.numbers + j;
    std::size_t here = (k_ - 1) * of_targets_.stride;
    IntBatch<Arch> had = load(distances + here);
    IntBatch<Arch> had_number = load(numbers + here);
    IntMask<Arch> enters = comes_before(distance, query, had, had_number);
    for (; here > 0; here -= of_targets_.stride) {
      const std::size_t above = here - of_targets_.stride;
      const IntBatch<Arch> next = load(distances + above);
      const IntBatch<Arch> next_number = load(numbers + above);
      const IntMask<Arch> falls = comes_before(distance, query, next, next_number);
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

}  // namespace consimd::detail
