// Sets of rows, or of vertices of a graph, as bits in 64-bit words.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <consimd/kernels/consistency_matrix.hpp>
#include <consimd/kernels/correspondences.hpp>

namespace consimd::detail {

/// Words that a set among `size` rows takes.
constexpr std::size_t words_for(std::size_t size) { return (size + kBlock - 1) / kBlock; }

inline void set_bit(std::span<std::uint64_t> set, std::size_t i) {
  set[i / kBlock] |= std::uint64_t{1} << (i % kBlock);
}

inline void clear_bit(std::span<std::uint64_t> set, std::size_t i) {
  set[i / kBlock] &= ~(std::uint64_t{1} << (i % kBlock));
}

inline bool test_bit(std::span<const std::uint64_t> set, std::size_t i) {
  return (set[i / kBlock] >> (i % kBlock) & 1) != 0;
}

inline bool is_empty(std::span<const std::uint64_t> set) {
  std::uint64_t any = 0;
  for (const std::uint64_t word : set) any |= word;
  return any == 0;
}

/// Calls visit(i) for every i in a word of a set, ascending. `word`: its index.
template <typename Visit>
void for_each_in_word(std::uint64_t bits, std::size_t word, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) {
    visit(static_cast<std::uint32_t>(word * kBlock + static_cast<std::size_t>(std::countr_zero(bits))));
  }
}

template <typename Visit>
void for_each_in(std::span<const std::uint64_t> set, const Visit& visit) {
  for (std::size_t w = 0; w < set.size(); ++w) for_each_in_word(set[w], w, visit);
}

/// Replaces `members` by those of the set, ascending.
inline void members_of(std::span<const std::uint64_t> set, std::vector<std::uint32_t>& members) {
  members.resize(popcount(set));
  auto next = members.begin();
  for_each_in(set, [&](std::uint32_t i) { *next++ = i; });
}

/// out = a & b; all of the same size, `out` may be one of them.
inline void intersect(std::span<const std::uint64_t> a, std::span<const std::uint64_t> b,
                      std::span<std::uint64_t> out) {
  for (std::size_t w = 0; w < out.size(); ++w) out[w] = a[w] & b[w];
}

}  // namespace consimd::detail
