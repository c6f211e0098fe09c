#include "verdict/pairing_chances.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <consimd/kernels/alignment_residuals.hpp>
#include <consimd/kernels/elementary_functions.hpp>

#include "sampling/counter_random.hpp"
#include "sampling/sampling.hpp"
#include "support/points.hpp"
#include "support/row_blocks.hpp"

namespace consimd::detail {
namespace {

constexpr double kFew = 8.0;       // hits that are taken as they are
constexpr double kTelling = 64.0;  // hits that tell a chance and how it grows
constexpr int kDoublings = 5;
constexpr double kPartOfFew = 0.25;        // of all pairs: further out a cloud ends
constexpr std::size_t kSurroundings = 64;  // doublings as well, which reach from any bound to all of a cloud

// The values were drawn from `distinct` ones, few of which maybe many times.
double share_below(const std::vector<double>& values, double distinct, double bound) {
  if (values.empty()) return chance(0.0, 0.0);
  const auto hits = static_cast<double>(std::ranges::count_if(values, [bound](double value) { return value < bound; }));
  const auto drawn = static_cast<double>(values.size());
  const double trials = std::min(drawn, distinct);
  return chance(hits * trials / drawn, trials);
}

// Calls visit(i, j, distance of the moved source of row i from the target of row j, working frame) for rows shifted one
// by one, as many shifts as there are to be. Returns the number of pairs.
template <typename Visit>
double for_each_shifted(const CorrespondenceView& view, const WorkingPose& pose, std::size_t shifts,
                        const Visit& visit) {
  const std::size_t size = view.size();
  std::vector<Point> sources(size);
  for (std::size_t i = 0; i < size; ++i) sources[i] = moved(pose, source_point(view, i));
  const std::size_t step = std::max<std::size_t>(1, (size - 1) / shifts);
  double pairs = 0.0;
  for (std::size_t shift = 1; shift < size; shift += step) {
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t j = i + shift < size ? i + shift : i + shift - size;
      visit(i, j, distance(sources[i], target_point(view, j)));
    }
    pairs += static_cast<double>(size);
  }
  return pairs;
}

// The chances at `bounds`, which descend from the first on.
std::vector<double> single_shift_chances(const CorrespondenceView& view, const WorkingPose& pose,
                                         std::span<const double> bounds, std::size_t shifts,
                                         const MatchedPoints& matched) {
  std::vector<double> result(bounds.size());
  const double widest = bounds.front() * view.scale();
  const double pairs = for_each_shifted(view, pose, shifts, [&](std::size_t i, std::size_t j, double apart) {
    if (!(apart < widest) || matched.contains(view, i, j)) return;
    for (std::size_t b = 0; b < bounds.size(); ++b) result[b] += apart < bounds[b] * view.scale() ? 1.0 : 0.0;
  });
  for (double& hits : result) hits = chance(hits, pairs);
  return result;
}

struct ShiftHits {
  double hits = 0.0;
  double trials = 0.0;
};

ShiftHits shift_hits(const CorrespondenceView& view, const WorkingPose& pose, double bound, std::uint32_t shifts) {
  const std::size_t size = view.size();
  ShiftHits result;
  const auto blocks = static_cast<std::uint32_t>((size - 1) / kBlock);
  const std::uint32_t used = std::min(shifts, blocks);
  std::vector<std::uint32_t> offsets(used);
  std::vector<std::uint32_t> counts(used);
  for (std::uint32_t s = 0; s < used; ++s) offsets[s] = 1 + s * blocks / used;
  row_blocks::mismatched_counts(view, pose, bound, offsets, counts);
  for (std::uint32_t s = 0; s < used; ++s) {
    result.hits += counts[s];
    result.trials += static_cast<double>(mismatched_pairs(view, offsets[s]));
  }
  return result;
}

double block_shift_chance(const CorrespondenceView& view, const WorkingPose& pose, double bound, std::uint32_t shifts,
                          RareHits rare) {
  const ShiftHits within = shift_hits(view, pose, bound, shifts);
  if (rare == RareHits::laplace || within.hits >= kFew) return chance(within.hits, within.trials);
  // Hits within twice the bound, and so on, until there are enough; none come nearer than those of the last step alone.
  double factor = 1.0;
  double former = within.hits;
  for (int doubling = 0; doubling < kDoublings; ++doubling) {
    factor *= 2.0;
    const ShiftHits wider = shift_hits(view, pose, factor * bound, shifts);
    if (wider.hits >= kTelling || doubling + 1 == kDoublings) {
      const double dimension =
          std::clamp(elementary::log((wider.hits + 1.0) / (former + 1.0)) / std::numbers::ln2, 1.0, 3.0);
      return std::max(within.hits / within.trials,
                      (wider.hits + 1.0) / wider.trials * elementary::exp(-dimension * elementary::log(factor)));
    }
    former = wider.hits;
  }
  return chance(within.hits, within.trials);
}

// Where all points are matched with all, whatever is within the bound is a row: it is matched, and nothing within the
// bound tells of chance. What is further out does: pairs within twice the bound, four times, and so on, until there are
// enough different ones. Their number grows as in one to three dimensions. Raises the chances to what that makes within
// each bound.
void raise_to_surroundings(const CorrespondenceView& view, const WorkingPose& pose, std::span<const double> bounds,
                           std::size_t shifts, const MatchedPoints& matched, std::vector<double>& chances) {
  const double of_bound = 1.0 / (matched.bound() * view.scale());
  std::array<double, kSurroundings> beyond{};  // hits from 2^k bounds on, up to twice as far
  const double trials = for_each_shifted(view, pose, shifts, [&](std::size_t, std::size_t, double apart) {
    const double bounds_apart = apart * of_bound;
    if (!(bounds_apart >= 1.0)) return;
    const int doublings = std::ilogb(bounds_apart);
    if (doublings < static_cast<int>(kSurroundings)) ++beyond[static_cast<std::size_t>(doublings)];
  });
  // Pairs of the same points count once.
  const double of_each = std::min(1.0, matched.different_pairs() / trials);
  const double enough = std::min(kTelling, kPartOfFew * matched.different_pairs());
  double hits = of_each * beyond[0];
  std::size_t k = 1;
  do {
    hits += of_each * beyond[k++];
  } while (k < kSurroundings && hits < enough);
  const double growth = (of_each * beyond[k - 1] + 1.0) / (of_each * beyond[k - 2] + 1.0);
  const double dimension = std::clamp(elementary::log(growth) / std::numbers::ln2, 1.0, 3.0);
  const double doublings = static_cast<double>(k) * std::numbers::ln2;
  const double share = chance(hits, of_each * trials) / (elementary::exp(dimension * doublings) - 1.0);
  for (std::size_t b = 0; b < bounds.size(); ++b) {
    const double within = elementary::exp(dimension * elementary::log(bounds[b] / matched.bound()));
    chances[b] = std::max(chances[b], std::min(1.0, share * within));
  }
}

}  // namespace

std::vector<double> pose_chances(const CorrespondenceView& view, const WorkingPose& pose,
                                 std::span<const double> bounds, std::uint32_t shifts, RareHits rare,
                                 const MatchedPoints& matched) {
  if (view.size() <= kFewCorrespondences || !matched.empty()) {
    const bool all = view.size() <= kFewCorrespondences && rare == RareHits::extrapolated;
    const std::size_t used = all ? view.size() : shifts;
    std::vector<double> result = single_shift_chances(view, pose, bounds, used, matched);
    if (!matched.empty()) raise_to_surroundings(view, pose, bounds, used, matched, result);
    return result;
  }
  std::vector<double> result;
  for (const double bound : bounds) result.push_back(block_shift_chance(view, pose, bound, shifts, rare));
  return result;
}

LengthChance::LengthChance(const CorrespondenceView& view, std::span<const std::uint32_t> explained,
                           std::uint32_t pairs, std::uint64_t seed)
    : scale_(view.scale()), pairs_(0.5 * static_cast<double>(view.size()) * static_cast<double>(view.size() - 1)) {
  const auto size = static_cast<std::uint32_t>(view.size());
  std::vector<bool> is_explained(view.size());
  for (const std::uint32_t row : explained) is_explained[row] = true;
  own_.reserve(pairs);
  mismatched_.reserve(pairs);
  for (std::uint32_t s = 0; s < pairs; ++s) {
    CounterRandom random(seed, RandomStage::background, s);
    const IndexPair from = draw_pair(random, size);
    const IndexPair to = draw_pair(random, size);
    const double length = distance(source_point(view, from.first), source_point(view, from.second));
    own_.push_back(is_explained[from.first] && is_explained[from.second]
                       ? std::numeric_limits<double>::infinity()
                       : std::abs(length - distance(target_point(view, from.first), target_point(view, from.second))));
    const bool reversed = from.first == to.second && from.second == to.first;
    if (from.first == to.first || from.second == to.second || reversed) continue;
    mismatched_.push_back(std::abs(length - distance(target_point(view, to.first), target_point(view, to.second))));
  }
}

double LengthChance::operator()(double bound) const {
  return std::max(share_below(own_, pairs_, bound * scale_),
                  share_below(mismatched_, pairs_ * (pairs_ - 1.0), bound * scale_));
}

}  // namespace consimd::detail
