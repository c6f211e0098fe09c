#include <algorithm>
#include <bit>

#include <consimd/solvers/pcr99.hpp>

namespace consimd {
namespace {

bool is_set(std::span<const std::uint64_t> row, std::size_t bit) {
  return (row[bit / kBlock] >> (bit % kBlock) & 1) != 0;
}

}  // namespace

RankedTriples::RankedTriples(const ConsistencyMatrix& matrix) : matrix_(matrix) {}

bool RankedTriples::done() const noexcept { return found_.empty() && sum_ + 6 > 3 * matrix_.size(); }

void RankedTriples::next(std::size_t count, std::uint64_t max_looked_at, std::vector<IndexTriple>& triples) {
  const std::size_t size = matrix_.size();
  // All that have the same sum and first row are looked at in one go; what is too many waits for the next call.
  while (found_.size() < count && looked_at_ < max_looked_at && sum_ + 6 <= 3 * size) {
    const std::size_t rest = sum_ - first_;  // j + k
    const std::size_t begin = std::max(first_ + 1, rest + 1 > size ? rest + 1 - size : 0);
    const std::size_t end = (rest + 1) / 2;
    if (3 * first_ + 3 > sum_) {
      ++sum_;
      first_ = sum_ + 3 > 2 * size ? sum_ + 3 - 2 * size : 0;
      continue;
    }
    const std::span<const std::uint64_t> row = matrix_.row(first_);
    for (std::size_t word = begin / kBlock; word * kBlock < end; ++word) {
      std::uint64_t bits = row[word];
      if (word == begin / kBlock) bits &= ~std::uint64_t{0} << (begin % kBlock);
      for (; bits != 0; bits &= bits - 1) {
        const std::size_t second = word * kBlock + static_cast<std::size_t>(std::countr_zero(bits));
        if (second >= end) break;
        const std::size_t third = rest - second;
        if (!is_set(row, third) || !is_set(matrix_.row(second), third)) continue;
        found_.push_back({static_cast<std::uint32_t>(first_), static_cast<std::uint32_t>(second),
                          static_cast<std::uint32_t>(third)});
      }
    }
    if (end > begin) looked_at_ += end - begin;
    ++first_;
  }
  const auto taken = found_.begin() + static_cast<std::ptrdiff_t>(std::min(count, found_.size()));
  triples.assign(found_.begin(), taken);
  found_.erase(found_.begin(), taken);
}

}  // namespace consimd
