#include "search/sparse_sets.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include <consimd/kernels/consistency_matrix.hpp>

#include "bits/bit_rows.hpp"

namespace consimd::detail {
namespace {

// Rows that agree with both of a pair that does, up to which all sets are looked at.
constexpr double kCommon = 16.0;
// The time, measured for 3000 rows of the noise study, in units of 0.75 ns: about that of all pairs, and of those that
// agree times the words of a row and ten times the rows that both agree with; at most that of some 60 ms of one core.
constexpr double kWorkOfPair = 1.0;
constexpr double kWorkOfCommon = 10.0;
constexpr double kLargestWork = 8e7;
// That of a seed is about that of a third of the rows and of 140 times those that agree with it.
constexpr double kSeedsWorkOfRow = 0.33;
constexpr double kSeedsWorkOfAgreeing = 140.0;
constexpr std::size_t kRowsPerTask = 16;
// Sets that are looked at for one row, at most; of 3000 rows in a cube with kCommon it takes up to 173.
constexpr std::size_t kNodes = 512;

// The largest sets that begin with one row. A row of a set of n agrees with n - 1 others of it and with itself.
class FirstRow {
 public:
  explicit FirstRow(const Correspondences& correspondences, double bound)
      : correspondences_(correspondences), bound_(bound) {}

  // The largest set of `least` or more rows, of those after `row` besides it; empty if there is none. Returns whether
  // it is the largest.
  bool find(const ConsistencyMatrix& matrix, std::uint32_t row, std::uint32_t least, std::vector<std::uint32_t>& set) {
    set.clear();
    std::vector<std::uint64_t>& later = level(0);
    later.assign(matrix.row(row).begin(), matrix.row(row).end());
    clear_up_to(later, row);
    // Once in the matrix takes out most of what goes; the rest is done among those that are left.
    cut({matrix.data(), matrix.size() * matrix.words()}, later, least - 1);
    members_of(later, rows_);
    if (rows_.size() + 1 < least) return true;
    subset_.assign_subset(correspondences_, rows_);
    later_matrix_.compute(subset_.view(), bound_);
    later.assign(later_matrix_.words(), 0);
    for (std::uint32_t i = 0; i < rows_.size(); ++i) set_bit(later, i);
    least_ = least;
    nodes_ = 0;
    chosen_.clear();
    best_.clear();
    look(0);
    if (!best_.empty()) set.push_back(row);
    for (const std::uint32_t i : best_) set.push_back(rows_[i]);
    return nodes_ < kNodes;
  }

 private:
  static void clear_up_to(std::span<std::uint64_t> set, std::uint32_t last) {
    std::fill_n(set.begin(), last / kBlock, 0);
    set[last / kBlock] &= last % kBlock + 1 == kBlock ? 0 : ~std::uint64_t{0} << (last % kBlock + 1);
  }

  std::vector<std::uint64_t>& level(std::size_t depth) {
    if (levels_.size() <= depth) levels_.resize(depth + 1);
    return levels_[depth];
  }

  // Takes out the members whose rows have fewer than `least` of the set, and tells whether there were any.
  bool cut(std::span<const std::uint64_t> bits, std::span<std::uint64_t> set, std::uint32_t least) {
    members_of(set, members_);
    counts_.resize(members_.size());
    and_popcount_rows(bits, set, members_, counts_);
    bool any = false;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (counts_[i] >= least) continue;
      clear_bit(set, members_[i]);
      any = true;
    }
    return any;
  }

  // The rows that may join the first and the chosen ones are those of the level.
  void look(std::size_t depth) {
    if (++nodes_ >= kNodes) return;
    const auto taken = static_cast<std::uint32_t>(1 + chosen_.size());
    const std::span<const std::uint64_t> bits{later_matrix_.data(), later_matrix_.size() * later_matrix_.words()};
    while (cut(bits, levels_[depth], least_ - std::min(least_, taken))) {
    }
    const auto size = static_cast<std::uint32_t>(members_.size());
    if (taken + size < least_) return;
    if (std::ranges::all_of(counts_, [size](std::uint32_t count) { return count == size; })) {
      best_ = chosen_;
      best_.insert(best_.end(), members_.begin(), members_.end());
      least_ = taken + size + 1;
      return;
    }
    const std::vector<std::uint32_t> candidates = members_;
    for (const std::uint32_t next : candidates) {
      std::vector<std::uint64_t>& common = level(depth + 1);
      common.resize(later_matrix_.words());
      intersect(levels_[depth], later_matrix_.row(next), common);
      clear_up_to(common, next);
      if (taken + 1 + popcount(common) < least_) continue;
      chosen_.push_back(next);
      look(depth + 1);
      chosen_.pop_back();
    }
  }

  const Correspondences& correspondences_;
  double bound_;
  std::uint32_t least_ = 0;
  std::size_t nodes_ = 0;
  std::vector<std::uint32_t> rows_;
  Correspondences subset_;
  ConsistencyMatrix later_matrix_;
  std::vector<std::vector<std::uint64_t>> levels_;
  std::vector<std::uint32_t> chosen_;
  std::vector<std::uint32_t> best_;
  std::vector<std::uint32_t> members_;
  std::vector<std::uint32_t> counts_;
};

// Rows far from the middle of both clouds first: those near it agree with many, and are the later the fewer of them
// there are to agree with. Rows without coordinates in the working frame, which agree with none, are the last.
std::vector<std::uint32_t> outermost_first(const CorrespondenceView& view) {
  std::vector<float> out(view.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const float* column : {view.source(axis), view.target(axis)}) {
      double sum = 0.0;
      double count = 0.0;
      for (std::size_t row = 0; row < view.size(); ++row) {
        if (std::isnan(column[row])) continue;
        sum += column[row];
        ++count;
      }
      const auto mean = static_cast<float>(sum / std::max(count, 1.0));
      for (std::size_t row = 0; row < view.size(); ++row) out[row] += (column[row] - mean) * (column[row] - mean);
    }
  }
  for (float& distance : out) distance = std::isnan(distance) ? -1.0F : distance;
  std::vector<std::uint32_t> order(view.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) { return out[a] > out[b]; });
  return order;
}

}  // namespace

double seeds_for_all_sets(std::size_t rows, double share, std::size_t matrix_budget_bytes) {
  const auto size = static_cast<double>(rows);
  const double common = size * share * share;
  const double of_agreeing = static_cast<double>(words_for(rows)) + kWorkOfCommon * common;
  const double work = 0.5 * size * size * (kWorkOfPair + share * of_agreeing);
  if (common > kCommon || work > kLargestWork || ConsistencyMatrix::memory_bytes(rows) > matrix_budget_bytes) {
    return std::numeric_limits<double>::infinity();
  }
  return work / (size * (kSeedsWorkOfRow + kSeedsWorkOfAgreeing * share));
}

std::uint32_t largest_by_chance(std::size_t rows, double share) {
  // C(rows, k) share^(k (k - 1) / 2), k by k.
  std::uint32_t k = 0;
  double sets = 1.0;
  for (double agreeing = 1.0; k < rows; ++k, agreeing *= share) {
    sets *= static_cast<double>(rows - k) / static_cast<double>(k + 1) * agreeing;
    if (sets < 1.0) break;
  }
  return k;
}

SparseSets sparse_sets(const Correspondences& correspondences, double bound, std::uint32_t least,
                       const StopCondition& stop) {
  const std::vector<std::uint32_t> order = outermost_first(correspondences.view());
  const Correspondences ordered = correspondences.subset(order);
  ConsistencyMatrix matrix;
  matrix.compute(ordered.view(), bound);
  const auto size = static_cast<std::uint32_t>(order.size());
  // Each row agrees with itself.
  const double agreeing = std::accumulate(matrix.degrees().begin(), matrix.degrees().end(), 0.0) - size;
  const double share = agreeing / std::max(1.0, static_cast<double>(size) * (static_cast<double>(size) - 1.0));
  const std::uint32_t least_set = std::max({least, largest_by_chance(size, share) + 1, 3U});
  SparseSets result;
  result.sets.resize(size);
  std::atomic<bool> all = true;
  tbb::enumerable_thread_specific<FirstRow> scratch([&] { return FirstRow(ordered, bound); });
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, size, kRowsPerTask), [&](const auto& range) {
    for (std::uint32_t row = range.begin(); row < range.end(); ++row) {
      if (!all.load(std::memory_order_relaxed)) return;
      const bool ended = stop.met() || !scratch.local().find(matrix, row, least_set, result.sets[row]);
      if (ended) all.store(false, std::memory_order_relaxed);
    }
  });
  if (!all) return {};
  result.all = true;
  result.least = least_set;
  std::erase_if(result.sets, [](const auto& set) { return set.empty(); });
  for (std::vector<std::uint32_t>& set : result.sets) {
    for (std::uint32_t& row : set) row = order[row];
    std::ranges::sort(set);
  }
  std::ranges::stable_sort(result.sets, [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return result;
}

}  // namespace consimd::detail
