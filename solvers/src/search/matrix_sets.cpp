#include "search/matrix_sets.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "bits/bit_rows.hpp"

namespace consimd::detail {

void MatrixSets::draw(const SeedWindow& window, std::uint32_t begin, std::span<std::uint32_t> sizes) {
  if (window_first_ != window.first() || matrix_.size() != window.size()) {
    matrix_.compute(window.rows(), bound_);
    window_first_ = window.first();
  }
  begin_ = begin;
  std::ranges::copy(matrix_.degrees().subspan(begin, sizes.size()), sizes.begin());
}

SetGuess MatrixSets::guess(const SeedWindow& window, std::uint32_t position, const TwoPointTuning& tuning) {
  const auto size = static_cast<float>(matrix_.degrees()[begin_ + position]);
  if (tuning.matrix_partners == 0) return {size, 0};
  Scratch& scratch = scratch_.local();
  const std::span<const std::uint64_t> set = matrix_.row(begin_ + position);
  const std::size_t stride = 1 + set.size() / tuning.matrix_partners;
  scratch.partners.clear();
  for (std::size_t w = 0; w < set.size(); w += stride) {
    if (set[w] == 0) continue;
    const auto partner = static_cast<std::uint32_t>(w * kBlock + static_cast<std::size_t>(std::countr_zero(set[w])));
    if (partner != begin_ + position) scratch.partners.push_back(partner);
  }
  scratch.counts.resize(scratch.partners.size());
  and_popcount_rows(matrix_, set, scratch.partners, scratch.counts);
  SetGuess best;
  for (std::size_t i = 0; i < scratch.partners.size(); ++i) {
    const std::uint32_t partner = scratch.partners[i];
    const float chance = static_cast<float>(matrix_.degrees()[partner]) / static_cast<float>(matrix_.size());
    if (chance >= 1.0F) continue;
    const float clique = (static_cast<float>(scratch.counts[i]) - chance * size) / (1.0F - chance);
    if (clique > best.clique) best = {clique, window.row(partner)};
  }
  return best;
}

void MatrixSets::prune(const SeedWindow& window, std::uint32_t position, std::uint32_t wanted, const TcfTuning& tuning,
                       std::vector<std::uint32_t>& set) {
  members_of(matrix_.row(begin_ + position), set);
  detail::prune(matrix_, set, wanted_of_part(window.share(), wanted, tuning.two_point), Merit::excess, tuning.pruning,
                scratch_.local().prune);
  for (std::uint32_t& member : set) member = window.row(member);
  std::ranges::sort(set);
}

}  // namespace consimd::detail
