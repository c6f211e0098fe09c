#include "call/distinct_rows.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <utility>

namespace consimd::detail {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// Odd, one a coordinate; what a hash needs of them is that their bits look random.
constexpr std::array<std::uint32_t, 6> kMultipliers{0x9E3779B1U, 0x85EBCA77U, 0xC2B2AE3DU,
                                                    0x27D4EB2FU, 0x165667B1U, 0x2C1B3C6DU};

const float* coordinate(const CorrespondenceView& view, std::size_t c) {
  return c < 3 ? view.source(c) : view.target(c - 3);
}

std::vector<std::uint32_t> hashes(const CorrespondenceView& view) {
  std::vector<std::uint32_t> result(view.size(), 0);
  for (std::size_t c = 0; c < 6; ++c) {
    const float* x = coordinate(view, c);
    for (std::size_t row = 0; row < view.size(); ++row) {
      std::uint32_t bits = std::bit_cast<std::uint32_t>(x[row]);
      bits ^= bits >> 15U;
      result[row] = (result[row] ^ bits) * kMultipliers[c];
      result[row] ^= result[row] >> 13U;
    }
  }
  return result;
}

bool equal(const CorrespondenceView& view, std::uint32_t a, std::uint32_t b) {
  for (std::size_t c = 0; c < 6; ++c) {
    const float* x = coordinate(view, c);
    if (std::bit_cast<std::uint32_t>(x[a]) != std::bit_cast<std::uint32_t>(x[b])) return false;
  }
  return true;
}

// For each row the first one that is equal to it. The table of first rows has open addresses.
std::vector<std::uint32_t> first_equal_rows(const CorrespondenceView& view) {
  std::vector<std::uint32_t> first = hashes(view);
  const std::size_t slots = std::bit_ceil(2 * view.size() + 1);
  const int shift = std::countl_zero(static_cast<std::uint32_t>(slots - 1));
  std::vector<std::uint32_t> table(slots, kNone);
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    std::size_t slot = first[row] >> shift;
    while (table[slot] != kNone && !equal(view, table[slot], row)) slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = row;
    first[row] = table[slot];
  }
  return first;
}

}  // namespace

DistinctRows::DistinctRows(const Correspondences& all) : all_(all) {
  std::vector<std::uint32_t> first = first_equal_rows(all.view());
  const auto far = all.far_rows();
  std::size_t copies = 0;
  for (std::uint32_t row = 0; row < first.size(); ++row) copies += first[row] == row ? 0U : 1U;
  if (copies == 0 && far.empty()) return;
  for (const std::uint32_t row : far) first[row] = kNone;
  position_ = std::move(first);
  for (std::uint32_t row = 0; row < position_.size(); ++row) {
    if (position_[row] == kNone) continue;
    if (position_[row] == row) {
      position_[row] = static_cast<std::uint32_t>(chosen_.size());
      chosen_.push_back(row);
    } else {
      position_[row] = position_[position_[row]];
    }
  }
  if (!chosen_.empty()) distinct_.assign_subset(all, chosen_);
}

void DistinctRows::restore(std::vector<std::uint32_t>& rows) const {
  if (chosen_.empty()) return;
  std::vector<bool> is_chosen(chosen_.size());
  for (const std::uint32_t row : rows) is_chosen[row] = true;
  rows.clear();
  for (std::uint32_t row = 0; row < position_.size(); ++row) {
    if (position_[row] != kNone && is_chosen[position_[row]]) rows.push_back(row);
  }
}

}  // namespace consimd::detail
