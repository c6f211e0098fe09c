#pragma once

#include <utility>

#include "../simd.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail {

/// A query's list of best matches while some are entered: keys of distance and index, which ascend as the ranks do.
template <typename Arch>
class QueryList {
 public:
  QueryList(const RawMatches& best, std::size_t k, std::size_t i) : best_(best), k_(k), i_(i) {
    for (std::size_t rank = 0; rank < k; ++rank) {
      const std::size_t at = rank * best.stride + i;
      keys_[rank] = key(best.distances[at], best.indices[at]);
    }
  }

  /// The match falls through the ranks and is exchanged for each that comes behind it: no branch, which could not be
  /// foreseen.
  void enter(std::int32_t distance, std::uint32_t index) {
    std::uint64_t falling = key(distance, index);
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
      best_.indices[at] = static_cast<std::uint32_t>(keys_[rank]);
    }
  }

 private:
  static std::uint64_t key(std::int32_t distance, std::uint32_t index) {
    return std::uint64_t{static_cast<std::uint32_t>(distance)} << 32U | index;
  }

  const RawMatches& best_;
  std::size_t k_;
  std::size_t i_;
  std::uint64_t keys_[kMostMatches];
};

template <typename Arch>
class MatchTile {
 public:
  MatchTile(const RawDescriptors& queries, const RawDescriptors& targets, std::size_t k, const RawMatches& of_queries,
            const RawMatches& of_targets)
      : queries_(queries), targets_(targets), k_(k), of_queries_(of_queries), of_targets_(of_targets) {}

  /// Queries i .. i + kRows - 1 against targets j .. j + 15.
  template <std::size_t kRows>
  void match(std::size_t i, std::size_t j) const {
    for (std::size_t part = 0; part < 16; part += kSpan) match_span<kRows>(i, j, part);
  }

 private:
  // Accumulators of four queries and two registers of targets fit into 16 registers.
  static constexpr std::size_t kRegisters = kWidth<Arch> == 16 ? 1 : 2;
  static constexpr std::size_t kSpan = kRegisters * kWidth<Arch>;
  using Span = IntBatch<Arch>[kRegisters];

  /// Distances of those queries of which one is near enough for a list.
  template <std::size_t kRows>
  struct NearRows {
    std::uint32_t rows = 0;  ///< a bit each
    alignas(64) std::int32_t distances[kRows][kSpan];
  };

  template <std::size_t kRows>
  void match_span(std::size_t i, std::size_t j, std::size_t part) const {
    Span products[kRows];
    for (auto& row : products) {
      for (auto& sum : row) sum = IntBatch<Arch>(0);
    }
    const std::size_t pairs = queries_.pairs;
    const std::int16_t* tile = targets_.tiles + 2 * (j * pairs + part);
    const std::int16_t* rows = queries_.rows + 2 * i * pairs;
    for (std::size_t c = 0; c < pairs; ++c) {
      Span target;
      for (std::size_t r = 0; r < kRegisters; ++r) target[r] = load(tile + 2 * (16 * c + r * kWidth<Arch>));
      for (std::size_t q = 0; q < kRows; ++q) {
        const IntBatch<Arch> query = broadcast_pair(rows + 2 * (q * pairs + c));
        for (std::size_t r = 0; r < kRegisters; ++r) {
          products[q][r] = sum_in_place(products[q][r], pair_products(target[r], query));
        }
      }
    }
    NearRows<kRows> near;
    // No loop: a register with a number that is known only at run time would live in memory, in the loop above as well.
    [&]<std::size_t... kRow>(std::index_sequence<kRow...>) {
      (keep_if_near<kRow>(i, j + part, products[kRow], near), ...);
    }
    (std::make_index_sequence<kRows>());
    // A call in between would send the registers of the rows to memory and back.
    for (; near.rows != 0; near.rows &= near.rows - 1) {
      const auto q = static_cast<std::size_t>(__builtin_ctz(near.rows));
      enter(i + q, j + part, near.distances[q]);
    }
  }

  /// Keeps the distances of query i + kRow to the targets from j on where one is near enough for one of the two lists.
  template <std::size_t kRow, std::size_t kRows>
  void keep_if_near(std::size_t i, std::size_t j, const Span& products, NearRows<kRows>& near) const {
    const std::size_t last = k_ - 1;
    // Beside the query's norm, which is common to all: it is added to what is kept.
    const std::int32_t norm = queries_.squared_norms[i + kRow];
    const IntBatch<Arch> limit_of_query(of_queries_.distances[last * of_queries_.stride + i + kRow] - norm);
    const IntBatch<Arch> norm_of_query(norm);
    Span distances;
    IntMask<Arch> any(false);
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const std::size_t at = j + r * kWidth<Arch>;
      distances[r] = load(targets_.squared_norms + at) - (products[r] + products[r]);
      const IntBatch<Arch> limit_of_targets =
          load(of_targets_.distances + last * of_targets_.stride + at) - norm_of_query;
      any = any | (distances[r] < limit_of_query) | (distances[r] < limit_of_targets);
    }
    if (__builtin_expect(bitmask(any) == 0, 1)) return;
    near.rows |= 1U << kRow;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      (distances[r] + norm_of_query).store_aligned(near.distances[kRow] + r * kWidth<Arch>);
    }
  }

  /// Enters the distances of query i to the targets from j on into the lists of both. What lies behind the last target
  /// enters its own list alone, which nobody reads.
  [[gnu::noinline]] void enter(std::size_t i, std::size_t j, const std::int32_t* distances) const {
    const IntBatch<Arch> limit(of_queries_.distances[(k_ - 1) * of_queries_.stride + i]);
    std::uint64_t near = 0;
    for (std::size_t part = 0; part < kSpan; part += kWidth<Arch>) {
      const IntBatch<Arch> these = load(distances + part);
      enter_query(j + part, these, IntBatch<Arch>(static_cast<std::int32_t>(i)));
      near |= bitmask(these < limit) << part;
    }
    const std::size_t there = j < targets_.size ? targets_.size - j : 0;
    if (there < kSpan) near &= (std::uint64_t{1} << there) - 1;
    if (near == 0) return;
    QueryList<Arch> list(of_queries_, k_, i);
    for (; near != 0; near &= near - 1) {
      const auto l = static_cast<std::size_t>(__builtin_ctzll(near));
      list.enter(distances[l], static_cast<std::uint32_t>(j + l));
    }
    list.store();
  }

  /// Enters a query into the lists of the targets from j on, as many as a register holds: from the last rank on each
  /// takes what was above it, the query, or what it had.
  void enter_query(std::size_t j, const IntBatch<Arch>& distance, const IntBatch<Arch>& query) const {
    std::int32_t* distances = of_targets_.distances + j;
    auto* indices = reinterpret_cast<std::int32_t*>(of_targets_.indices) + j;
    std::size_t here = (k_ - 1) * of_targets_.stride;
    IntBatch<Arch> had = load(distances + here);
    IntBatch<Arch> had_index = load(indices + here);
    IntMask<Arch> enters = distance < had;
    for (; here > 0; here -= of_targets_.stride) {
      const std::size_t above = here - of_targets_.stride;
      const IntBatch<Arch> next = load(distances + above);
      const IntBatch<Arch> next_index = load(indices + above);
      const IntMask<Arch> falls = distance < next;
      xsimd::select(falls, next, xsimd::select(enters, distance, had)).store_aligned(distances + here);
      xsimd::select(falls, next_index, xsimd::select(enters, query, had_index)).store_aligned(indices + here);
      had = next;
      had_index = next_index;
      enters = falls;
    }
    xsimd::select(enters, distance, had).store_aligned(distances);
    xsimd::select(enters, query, had_index).store_aligned(indices);
  }

  template <typename T>
  static IntBatch<Arch> load(const T* from) {
    return IntBatch<Arch>::load_aligned(reinterpret_cast<const std::int32_t*>(from));
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

template <typename Arch>
void best_matches(const RawDescriptors& queries, std::size_t first, std::size_t last, const RawDescriptors& targets,
                  std::size_t k, const RawMatches& of_queries, const RawMatches& of_targets) {
  // As many targets as the first-level cache holds, with their matches.
  constexpr std::size_t kTile = 128;
  constexpr std::size_t kRows = 4;
  const MatchTile<Arch> tile(queries, targets, k, of_queries, of_targets);
  for (std::size_t begin = 0; begin < targets.size; begin += kTile) {
    const std::size_t end = targets.size - begin < kTile ? targets.size : begin + kTile;
    std::size_t i = first;
    for (; i + kRows <= last; i += kRows) {
      for (std::size_t j = begin; j < end; j += 16) tile.template match<kRows>(i, j);
    }
    for (; i < last; ++i) {
      for (std::size_t j = begin; j < end; j += 16) tile.template match<1>(i, j);
    }
  }
}

}  // namespace consimd::detail
