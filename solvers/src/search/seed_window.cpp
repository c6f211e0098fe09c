#include "search/seed_window.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace consimd::detail {

SeedWindow::SeedWindow(const Correspondences& correspondences, std::uint64_t seed)
    : correspondences_(correspondences), random_(seed, RandomStage::permutation, 0), order_(correspondences.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
}

void SeedWindow::move(std::uint32_t begin, std::uint32_t end, std::size_t size) {
  if (window_.size() == size && begin >= first_ && end <= first_ + size) return;
  const auto total = static_cast<std::uint32_t>(order_.size());
  first_ = std::min(begin, static_cast<std::uint32_t>(total - size));
  for (; shuffled_ < first_ + size; ++shuffled_) {
    std::swap(order_[shuffled_], order_[shuffled_ + random_.below(total - shuffled_)]);
  }
  window_.assign_subset(correspondences_, std::span(order_).subspan(first_, size));
}

double SeedWindow::share() const { return static_cast<double>(window_.size()) / static_cast<double>(order_.size()); }

}  // namespace consimd::detail
