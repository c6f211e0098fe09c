#include "support/repeated_points.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

#include "sampling/counter_random.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

constexpr std::size_t kLookedAt = 128;
constexpr std::size_t kLeastEqual = 3;
// Draws are the same whatever the caller's seed is.
constexpr std::uint64_t kFixedSeed = 0;

std::uint32_t hash(const Point& p) {
  std::uint32_t result = 0;
  for (const float x : {p.x, p.y, p.z}) {
    result = (result ^ std::bit_cast<std::uint32_t>(x)) * 0x9E3779B1U;
    result ^= result >> 15U;
  }
  return result;
}

// Points, to look others up. Most that are none of them are told by a bit.
template <typename PointOf>
class PointSet {
 public:
  PointSet(std::span<const std::uint32_t> members, const PointOf& point_of) : point_of_(point_of), bits_(kBits) {
    keys_.reserve(members.size());
    for (const std::uint32_t row : members) {
      keys_.push_back(key(row));
      bits_[hash(point_of_(row)) % kBits] = true;
    }
    std::ranges::sort(keys_);
  }

  [[nodiscard]] bool contains_point_of(std::uint32_t row) const {
    return bits_[hash(point_of_(row)) % kBits] && std::ranges::binary_search(keys_, key(row));
  }

 private:
  static constexpr std::uint32_t kBits = std::uint32_t{1} << 15U;

  [[nodiscard]] std::array<float, 3> key(std::uint32_t row) const {
    const Point p = point_of_(row);
    return {p.x, p.y, p.z};
  }

  const PointOf& point_of_;
  std::vector<bool> bits_;
  std::vector<std::array<float, 3>> keys_;  // in order
};

// Some rows from all over, each once; drawn, since the order of rows that share a point has a period.
std::vector<std::uint32_t> looked_at(std::size_t size) {
  std::vector<std::uint32_t> rows(std::min(size, kLookedAt));
  std::iota(rows.begin(), rows.end(), 0U);
  if (rows.size() == size) return rows;
  CounterRandom random(kFixedSeed, RandomStage::repeated_points, 0);
  for (std::uint32_t& row : rows) row = random.below(static_cast<std::uint32_t>(size));
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  return rows;
}

// Rows that a point is in, mean over the rows looked at. Points whose hashes are equal count as equal: hardly any are
// not.
template <typename PointOf>
double rows_a_point(const std::vector<std::uint32_t>& rows, std::size_t size, const PointOf& point_of) {
  std::vector<std::uint32_t> hashes;
  hashes.reserve(rows.size());
  for (const std::uint32_t row : rows) hashes.push_back(hash(point_of(row)));
  std::ranges::sort(hashes);
  std::size_t equal_pairs = 0;
  for (std::size_t first = 0, next = 0; first < hashes.size(); first = next) {
    while (next < hashes.size() && hashes[next] == hashes[first]) ++next;
    equal_pairs += (next - first) * (next - first - 1) / 2;
  }
  if (equal_pairs < kLeastEqual) return 1.0;
  const double pairs = 0.5 * static_cast<double>(rows.size()) * (static_cast<double>(rows.size()) - 1.0);
  return 1.0 + static_cast<double>(equal_pairs) * static_cast<double>(size) / pairs;
}

struct RowsAPoint {
  double of_source;
  double of_target;
};

RowsAPoint rows_a_point(const CorrespondenceView& view) {
  const std::vector<std::uint32_t> rows = looked_at(view.size());
  return {rows_a_point(rows, view.size(), [&](std::uint32_t row) { return source_point(view, row); }),
          rows_a_point(rows, view.size(), [&](std::uint32_t row) { return target_point(view, row); })};
}

std::array<float, 6> pair_of(const CorrespondenceView& view, std::size_t source_row, std::size_t target_row) {
  const Point p = source_point(view, source_row);
  const Point q = target_point(view, target_row);
  return {p.x, p.y, p.z, q.x, q.y, q.z};
}

}  // namespace

MatchedPoints::MatchedPoints(const CorrespondenceView& view, const WorkingPose& pose, double bound) : bound_(bound) {
  const RowsAPoint rows = rows_a_point(view);
  if (std::min(rows.of_source, rows.of_target) < kManyRows) return;
  const auto size = static_cast<double>(view.size());
  different_pairs_ = size / rows.of_source * (size / rows.of_target);
  for (const std::uint32_t row : pose_inliers(view, pose, bound)) pairs_.push_back(pair_of(view, row, row));
  std::ranges::sort(pairs_);
}

bool MatchedPoints::contains(const CorrespondenceView& view, std::size_t source_row, std::size_t target_row) const {
  return !empty() && std::ranges::binary_search(pairs_, pair_of(view, source_row, target_row));
}

bool one_to_many(const CorrespondenceView& view) {
  const RowsAPoint rows = rows_a_point(view);
  return std::max(rows.of_source, rows.of_target) >= kManyRows;
}

std::vector<std::uint32_t> rows_sharing_a_point(const CorrespondenceView& view,
                                                std::span<const std::uint32_t> members) {
  const auto source_of = [&](std::uint32_t row) { return source_point(view, row); };
  const auto target_of = [&](std::uint32_t row) { return target_point(view, row); };
  const PointSet sources(members, source_of);
  const PointSet targets(members, target_of);
  std::vector<std::uint32_t> rows;
  auto member = members.begin();
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    if (member != members.end() && *member == row) {
      ++member;
    } else if (sources.contains_point_of(row) || targets.contains_point_of(row)) {
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace consimd::detail
