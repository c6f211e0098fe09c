#pragma once

#include <utility>

#include "../simd.hpp"
#include "cloud_kernels.hpp"

namespace consimd::detail {

/// As in scalar.cpp.
template <typename Arch>
inline void enter_match(const RawMatches& best, std::size_t k, std::size_t i, std::int32_t distance,
                        std::uint32_t index, Arch /*tag*/) {
  std::size_t rank = k - 1;
  if (!(distance < best.distances[rank * best.stride + i])) return;
  for (; rank > 0 && distance < best.distances[(rank - 1) * best.stride + i]; --rank) {
    best.distances[rank * best.stride + i] = best.distances[(rank - 1) * best.stride + i];
    best.indices[rank * best.stride + i] = best.indices[(rank - 1) * best.stride + i];
  }
  best.distances[rank * best.stride + i] = distance;
  best.indices[rank * best.stride + i] = index;
}

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

  template <std::size_t kRows>
  void match_span(std::size_t i, std::size_t j, std::size_t part) const {
    IntBatch<Arch> products[kRows][kRegisters];
    for (auto& row : products) {
      for (auto& sum : row) sum = IntBatch<Arch>(0);
    }
    const std::size_t pairs = queries_.pairs;
    const std::int16_t* tile = targets_.tiles + 2 * (j * pairs + part);
    const std::int16_t* rows = queries_.rows + 2 * i * pairs;
    for (std::size_t c = 0; c < pairs; ++c) {
      IntBatch<Arch> target[kRegisters];
      for (std::size_t r = 0; r < kRegisters; ++r) target[r] = load(tile + 2 * (16 * c + r * kWidth<Arch>));
      for (std::size_t q = 0; q < kRows; ++q) {
        const IntBatch<Arch> query = broadcast_pair(rows + 2 * (q * pairs + c));
        for (std::size_t r = 0; r < kRegisters; ++r) {
          products[q][r] = products[q][r] + pair_products(target[r], query);
        }
      }
    }
    // No loop: a register with a number that is known only at run time would live in memory, in the loop above as well.
    [&]<std::size_t... kRow>(std::index_sequence<kRow...>) { (enter_if_near(i + kRow, j + part, products[kRow]), ...); }
    (std::make_index_sequence<kRows>());
  }

  /// Enters those targets from j on, as many as there are products, that are near enough for one of the two lists.
  void enter_if_near(std::size_t i, std::size_t j, const IntBatch<Arch> (&products)[kRegisters]) const {
    const std::size_t last = k_ - 1;
    // Beside the query's norm, which is common to all: it is added when a target enters.
    const std::int32_t norm = queries_.squared_norms[i];
    const IntBatch<Arch> limit_of_query(of_queries_.distances[last * of_queries_.stride + i] - norm);
    const IntBatch<Arch> norm_of_query(norm);
    IntBatch<Arch> distances[kRegisters];
    std::uint64_t bits = 0;
    for (std::size_t r = 0; r < kRegisters; ++r) {
      const std::size_t at = j + r * kWidth<Arch>;
      distances[r] = load(targets_.squared_norms + at) - (products[r] + products[r]);
      const IntBatch<Arch> limit_of_targets =
          load(of_targets_.distances + last * of_targets_.stride + at) - norm_of_query;
      bits |= bitmask((distances[r] < limit_of_query) | (distances[r] < limit_of_targets)) << (r * kWidth<Arch>);
    }
    if (__builtin_expect(bits == 0, 1)) return;
    alignas(64) std::int32_t lanes[kSpan];
    for (std::size_t r = 0; r < kRegisters; ++r) (distances[r] + norm_of_query).store_aligned(lanes + r * kWidth<Arch>);
    enter(i, j, bits, lanes);
  }

  [[gnu::noinline]] void enter(std::size_t i, std::size_t j, std::uint64_t bits, const std::int32_t* distances) const {
    for (; bits != 0; bits &= bits - 1) {
      const auto l = static_cast<std::size_t>(__builtin_ctzll(bits));
      if (j + l >= targets_.size) return;
      enter_match(of_queries_, k_, i, distances[l], static_cast<std::uint32_t>(j + l), Arch{});
      enter_match(of_targets_, k_, j + l, distances[l], static_cast<std::uint32_t>(i), Arch{});
    }
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

  const RawDescriptors& queries_;
  const RawDescriptors& targets_;
  std::size_t k_;
  const RawMatches& of_queries_;
  const RawMatches& of_targets_;
};

template <typename Arch>
void best_matches(const RawDescriptors& queries, std::size_t first, std::size_t last, const RawDescriptors& targets,
                  std::size_t k, const RawMatches& of_queries, const RawMatches& of_targets) {
  // As many targets as the first-level cache holds, with their matches.
  constexpr std::size_t kTile = 128;
  const MatchTile<Arch> tile(queries, targets, k, of_queries, of_targets);
  for (std::size_t begin = 0; begin < targets.size; begin += kTile) {
    const std::size_t end = targets.size - begin < kTile ? targets.size : begin + kTile;
    std::size_t i = first;
    for (; i + 4 <= last; i += 4) {
      for (std::size_t j = begin; j < end; j += 16) tile.template match<4>(i, j);
    }
    for (; i < last; ++i) {
      for (std::size_t j = begin; j < end; j += 16) tile.template match<1>(i, j);
    }
  }
}

}  // namespace consimd::detail
