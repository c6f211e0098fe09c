#include "verdict/lookalikes.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "sampling/counter_random.hpp"
#include "support/cell_keys.hpp"
#include "support/points.hpp"

namespace consimd::detail {
namespace {

// Places of the target that fewer rows have tell nothing of lookalikes: the three nearest descriptors of each, which is
// what matchers give, have one right answer among them more often than chance has it.
constexpr std::size_t kLeastRows = static_cast<std::size_t>(kManyRows);
// Edge of the cells that are places, in noise bounds: six deviations of a residual.
constexpr double kPlace = 2.0;
// Sources that are looked at for each row, and rows of each of them.
constexpr std::size_t kSources = 8;
constexpr std::size_t kRows = 4;

// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

// Among few, in order or not, those that are looked at one by one are found sooner.
constexpr std::size_t kOneByOne = 8;
bool contains(std::span<const std::uint32_t> ascending, std::uint32_t value) {
  return ascending.size() <= kOneByOne ? std::ranges::find(ascending, value) != ascending.end()
                                       : std::ranges::binary_search(ascending, value);
}

// The points of one cloud, place by place.
class Places {
 public:
  template <typename PointOf>
  Places(std::size_t size, double edge, const PointOf& point_of) : place_(size), rows_(size) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> cells(size);
    for (std::uint32_t row = 0; row < size; ++row) cells[row] = {cell_key(point_of(row), edge), row};
    std::ranges::sort(cells);
    for (std::size_t k = 0; k < size; ++k) {
      if (k == 0 || cells[k].first != cells[k - 1].first) first_.push_back(static_cast<std::uint32_t>(k));
      rows_[k] = cells[k].second;
      place_[rows_[k]] = static_cast<std::uint32_t>(first_.size() - 1);
    }
    first_.push_back(static_cast<std::uint32_t>(size));
  }

  [[nodiscard]] std::size_t size() const { return first_.size() - 1; }
  [[nodiscard]] std::uint32_t place(std::uint32_t row) const { return place_[row]; }
  [[nodiscard]] std::size_t rows(std::uint32_t place) const { return first_[place + 1] - first_[place]; }

  // Rows before those at a place.
  [[nodiscard]] std::size_t before(std::uint32_t place) const { return first_[place]; }
  [[nodiscard]] std::span<const std::uint32_t> at(std::uint32_t place) const {
    return std::span(rows_).subspan(first_[place], rows(place));
  }

  // The k-th of up to `most` rows at a place, from all over them.
  template <typename Visit>
  void visit(std::uint32_t place, std::size_t most, const Visit& visit) const {
    const std::size_t begin = first_[place];
    const std::size_t count = std::min(rows(place), most);
    const bool all = rows(place) <= most;  // a division takes longer than the rest
    for (std::size_t k = 0; k < count; ++k) {
      visit(rows_[begin + (all ? k : k * rows(place) / count)]);
    }
  }

 private:
  std::vector<std::uint32_t> place_;  // of a row
  std::vector<std::uint32_t> rows_;   // place by place
  std::vector<std::uint32_t> first_;  // in rows_, of a place; one more: the end
};

}  // namespace

Lookalikes::Lookalikes(const CorrespondenceView& view, double noise_bound, double apart)
    : view_(view), end_(view.size()) {
  const auto size = static_cast<std::uint32_t>(view.size());
  const double edge = kPlace * noise_bound * view.scale();
  const Places sources(size, edge, [&](std::size_t row) { return source_point(view, row); });
  const Places targets(size, edge, [&](std::size_t row) { return target_point(view, row); });
  // Places of the target that the rows at a place of the source were matched with, place by place.
  std::vector<std::uint32_t> matched(size);
  const auto matched_at = [&](std::uint32_t place) {
    return std::span(matched).subspan(sources.before(place), sources.rows(place));
  };
  for (std::uint32_t place = 0; place < sources.size(); ++place) {
    const std::span<std::uint32_t> here = matched_at(place);
    std::ranges::transform(sources.at(place), here.begin(), [&](std::uint32_t row) { return targets.place(row); });
    std::ranges::sort(here);
  }
  const auto limit = static_cast<float>(apart * view.scale() * apart * view.scale());
  for (std::uint32_t row = 0; row < size; ++row) {
    end_[row] = static_cast<std::uint32_t>(mates_.size());
    const std::span<const std::uint32_t> own = matched_at(sources.place(row));
    if (targets.rows(targets.place(row)) < kLeastRows) continue;
    targets.visit(targets.place(row), kSources, [&](std::uint32_t like) {
      if (!(squared_distance(source_point(view, row), source_point(view, like)) >= limit)) return;
      sources.visit(sources.place(like), kRows, [&](std::uint32_t mate) {
        if (contains(own, targets.place(mate))) return;
        mates_.push_back(mate);
      });
    });
    end_[row] = static_cast<std::uint32_t>(mates_.size());
  }
}

PairingHits Lookalikes::support(const WorkingPose& pose, double bound, const MatchedPoints& matched) const {
  const double limit = bound * view_.scale();
  PairingHits result;
  result.trials = static_cast<double>(mates_.size());
  for (std::uint32_t row = 0; row < end_.size(); ++row) {
    const std::uint32_t begin = first(row);
    const double share = 1.0 / std::max(end_[row] - begin, 1U);
    const Point p = moved(pose, source_point(view_, row));
    for (std::uint32_t k = begin; k < end_[row]; ++k) {
      const double residual = distance(p, target_point(view_, mates_[k]));
      if (residual >= limit || matched.contains(view_, row, mates_[k])) continue;
      for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
        result.hits[b] += residual < kTestedBounds[b] * limit ? share : 0.0;
      }
    }
  }
  for (double& hits : result.hits) hits *= result.trials / static_cast<double>(std::max<std::size_t>(end_.size(), 1));
  return result;
}

PairingHits Lookalikes::lengths(double bound, std::uint32_t pairs) const {
  PairingHits result;
  const auto size = static_cast<std::uint32_t>(end_.size());
  const double tolerance = 2.0 * bound * view_.scale();
  for (std::uint32_t k = 0; k < pairs; ++k) {
    CounterRandom random(kFixedSeed, RandomStage::background, k);
    const std::uint32_t a = random.below(size);
    const std::uint32_t b = random.below(size);
    const auto exchanged = [&](std::uint32_t row) {
      const std::uint32_t mates = end_[row] - first(row);
      return mates == 0 ? row : mates_[first(row) + random.below(mates)];
    };
    const std::uint32_t from = exchanged(a);
    const std::uint32_t to = exchanged(b);
    add_length(result, view_, a, b, from, to, tolerance);
  }
  return result;
}

}  // namespace consimd::detail
