#include "verdict/kept_structure.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "sampling/counter_random.hpp"
#include "support/points.hpp"

namespace consimd::detail {
namespace {

// What a stratum's rows may share: positions along the axes of least, middle and greatest spread, distances from the
// origin and from the centroid.
enum class Coordinate : std::uint8_t { least, middle, greatest, range, from_centroid };
constexpr std::size_t kCoordinates = 5;
constexpr std::size_t position(Coordinate c) { return static_cast<std::size_t>(c); }

// Some of them.
struct Kept {
  std::array<Coordinate, 3> coordinates;
  std::size_t count;
};
constexpr Kept kept(Coordinate a) { return {{a}, 1}; }
constexpr Kept kept(Coordinate a, Coordinate b) { return {{a, b}, 2}; }
constexpr Kept kept(Coordinate a, Coordinate b, Coordinate c) { return {{a, b, c}, 3}; }

constexpr std::array kKept{kept(Coordinate::from_centroid),
                           kept(Coordinate::from_centroid, Coordinate::least),
                           kept(Coordinate::least),
                           kept(Coordinate::middle),
                           kept(Coordinate::greatest),
                           kept(Coordinate::range),
                           kept(Coordinate::least, Coordinate::middle),
                           kept(Coordinate::range, Coordinate::least),
                           kept(Coordinate::range, Coordinate::middle),
                           kept(Coordinate::range, Coordinate::greatest),
                           kept(Coordinate::least, Coordinate::middle, Coordinate::greatest)};
// At a second glance: all kinds that synthetic structure comes in, of a sample of the rows.
constexpr std::array kTelling{kept(Coordinate::least), kept(Coordinate::range), kept(Coordinate::from_centroid),
                              kept(Coordinate::least, Coordinate::middle),
                              kept(Coordinate::least, Coordinate::middle, Coordinate::greatest)};
constexpr std::size_t kSampledRows = 512;
constexpr std::size_t kSampledStratumRows = 16;

// Of the coherence of outliers: steps of the distance, the lift over chance from which correspondences move as one, and
// how many pairs a step needs.
constexpr double kStep = 0.5;  // in noise bounds
constexpr std::size_t kSteps = 7;
constexpr double kCoherentLift = 2.5;
constexpr double kLeastPairs = 20.0;
constexpr std::uint32_t kLookedAt = 256;
constexpr std::uint32_t kRandomPairs = 8192;

// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

// Bits of a number, ascending as the numbers are.
std::uint32_t ascending_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}

// Sorts `order` by `key` of its members, which is below `keys`; equal keys stay in order.
template <typename Key>
void sort_by_key(std::vector<std::uint32_t>& order, std::size_t keys, const Key& key) {
  std::vector<std::uint32_t> end(keys + 1);
  for (const std::uint32_t i : order) ++end[key(i) + 1];
  std::partial_sum(end.begin(), end.end(), end.begin());
  std::vector<std::uint32_t> sorted(order.size());
  for (const std::uint32_t i : order) sorted[end[key(i)]++] = i;
  order.swap(sorted);
}

// One coordinate of the sources.
struct Axis {
  std::vector<std::uint32_t> order;  // of the values, ascending
  double spread = 0.0;               // of the middle four fifths of them
};

Axis axis_of(const std::vector<float>& values) {
  constexpr unsigned kBits = 11;
  constexpr std::size_t kKeys = 1U << kBits;
  std::vector<std::uint32_t> bits(values.size());
  std::ranges::transform(values, bits.begin(), ascending_bits);
  Axis axis;
  axis.order.resize(values.size());
  std::iota(axis.order.begin(), axis.order.end(), 0U);
  for (unsigned shift = 0; shift < 32; shift += kBits) {
    sort_by_key(axis.order, kKeys, [&](std::uint32_t i) { return (bits[i] >> shift) % kKeys; });
  }
  const std::size_t tenth = values.size() / 10;
  axis.spread = static_cast<double>(values[axis.order[values.size() - 1 - tenth]]) -
                static_cast<double>(values[axis.order[tenth]]);
  return axis;
}

// Into how many slabs each of the axes is cut, so that cells of about `rows` rows are about as long in all of them.
std::vector<std::size_t> slabs(std::span<const Axis* const> axes, std::size_t size, std::size_t rows) {
  const double cells = std::max(1.0, static_cast<double>(size) / static_cast<double>(rows));
  double volume = 1.0;
  for (const Axis* axis : axes) volume *= std::max(axis->spread, 1e-9);
  const double length = std::pow(volume / cells, 1.0 / static_cast<double>(axes.size()));
  std::vector<std::size_t> result;
  for (const Axis* axis : axes) {
    result.push_back(static_cast<std::size_t>(std::clamp(std::round(axis->spread / length), 1.0, cells)));
  }
  return result;
}

// Strata of at most `largest` rows that agree in the axes: slabs of equal number along the first, each cut into such
// along the second, and so on. `rows`: what the axes' positions stand for.
Strata strata_along(std::span<const Axis* const> axes, const std::vector<std::uint32_t>& rows, std::size_t largest) {
  const std::vector<std::size_t> cuts = slabs(axes, rows.size(), largest);
  std::vector<std::uint32_t> cell(rows.size());
  std::size_t cells = 1;
  std::vector<std::uint32_t> order;
  std::vector<std::uint32_t> first;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    order = axes[a]->order;
    sort_by_key(order, cells, [&](std::uint32_t i) { return cell[i]; });
    const bool last = a + 1 == axes.size();
    for (std::size_t begin = 0; begin < order.size();) {
      const std::uint32_t of = cell[order[begin]];
      std::size_t end = begin;
      while (end < order.size() && cell[order[end]] == of) ++end;
      const std::size_t parts = last ? (end - begin + largest - 1) / largest : cuts[a];
      for (std::size_t part = 0; part < parts; ++part) {
        const std::size_t from = begin + part * (end - begin) / parts;
        const std::size_t to = begin + (part + 1) * (end - begin) / parts;
        if (last && from < to) first.push_back(static_cast<std::uint32_t>(from));
        if (last) continue;
        for (std::size_t position = from; position < to; ++position) {
          cell[order[position]] = static_cast<std::uint32_t>(of * parts + part);
        }
      }
      begin = end;
    }
    cells *= cuts[a];
  }
  first.push_back(static_cast<std::uint32_t>(order.size()));
  for (std::uint32_t& i : order) i = rows[i];
  return {std::move(order), std::move(first)};
}

// Moved sources, sources and targets of a stratum, coordinate by coordinate.
struct StratumPoints {
  std::array<std::array<float, kStratumRows>, 3> moved;
  std::array<std::array<float, kStratumRows>, 3> source;
  std::array<std::array<float, kStratumRows>, 3> target;
};

float squared(float x, float y, float z) { return x * x + y * y + z * z; }

}  // namespace

Strata::Strata(std::vector<std::uint32_t> rows, std::vector<std::uint32_t> first)
    : rows_(std::move(rows)), first_(std::move(first)) {
  stratum_of_.reserve(rows_.size());
  for (std::uint32_t s = 0; s + 1 < first_.size(); ++s) {
    stratum_of_.insert(stratum_of_.end(), first_[s + 1] - first_[s], s);
  }
}

PairingHits Strata::support(const CorrespondenceView& view, const WorkingPose& pose, double bound, double apart,
                            const MatchedPoints& matched) const {
  const auto limit = static_cast<float>(bound * view.scale() * bound * view.scale());
  const auto far = static_cast<float>(apart * view.scale() * apart * view.scale());
  PairingHits result;
  StratumPoints points;
  std::array<float, kStratumRows> residual{};
  std::array<float, kStratumRows> distance{};
  for (std::size_t s = 0; s + 1 < first_.size(); ++s) {
    const std::size_t size = first_[s + 1] - first_[s];
    for (std::size_t i = 0; i < size; ++i) {
      const std::uint32_t row = rows_[first_[s] + i];
      const Point p = source_point(view, row);
      const Point m = moved(pose, p);
      const Point q = target_point(view, row);
      for (const auto& [to, from] : {std::pair(&points.source, p), {&points.moved, m}, {&points.target, q}}) {
        (*to)[0][i] = from.x;
        (*to)[1][i] = from.y;
        (*to)[2][i] = from.z;
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      int mates = 0;
      int hits = 0;
      for (std::size_t j = 0; j < size; ++j) {
        residual[j] = squared(points.moved[0][i] - points.target[0][j], points.moved[1][i] - points.target[1][j],
                              points.moved[2][i] - points.target[2][j]);
        distance[j] = squared(points.source[0][i] - points.source[0][j], points.source[1][i] - points.source[1][j],
                              points.source[2][i] - points.source[2][j]);
        const int is_mate = distance[j] >= far ? 1 : 0;
        mates += is_mate;
        hits += residual[j] < limit ? is_mate : 0;
      }
      result.trials += mates;
      if (hits == 0) continue;
      for (std::size_t j = 0; j < size; ++j) {
        if (!(distance[j] >= far) || !(residual[j] < limit)) continue;
        if (matched.contains(view, rows_[first_[s] + i], rows_[first_[s] + j])) continue;
        for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
          const auto share = static_cast<float>(kTestedBounds[b] * kTestedBounds[b]);
          if (residual[j] < share * limit) result.hits[b] += 1.0 / mates;
        }
      }
    }
  }
  for (double& hits : result.hits) hits *= result.trials / static_cast<double>(std::max<std::size_t>(rows_.size(), 1));
  return result;
}

PairingHits Strata::lengths(const CorrespondenceView& view, double bound, std::uint32_t pairs) const {
  PairingHits result;
  const auto size = static_cast<std::uint32_t>(rows_.size());
  const double tolerance = 2.0 * bound * view.scale();
  for (std::uint32_t k = 0; k < pairs; ++k) {
    CounterRandom random(kFixedSeed, RandomStage::background, k);
    const auto exchanged = [&](std::uint32_t position) {
      const std::uint32_t s = stratum_of_[position];
      return rows_[first_[s] + random.below(first_[s + 1] - first_[s])];
    };
    const std::uint32_t at_a = random.below(size);
    const std::uint32_t at_b = random.below(size);
    const std::uint32_t a = rows_[at_a];
    const std::uint32_t b = rows_[at_b];
    const std::uint32_t from = exchanged(at_a);
    const std::uint32_t to = exchanged(at_b);
    // The pair as it is, forwards or backwards, is no chance.
    if (a == b || from == to || from == a || to == b || (from == b && to == a)) continue;
    const double difference = std::abs(distance(source_point(view, a), source_point(view, b)) -
                                       distance(target_point(view, from), target_point(view, to)));
    ++result.trials;
    for (std::size_t t = 0; t < kTestedBounds.size(); ++t) {
      if (difference < kTestedBounds[t] * tolerance) ++result.hits[t];
    }
  }
  return result;
}

namespace {

// Strata by each of `kept`, of every `step`-th row.
std::vector<Strata> strata_by(const Correspondences& correspondences, std::span<const Kept> all_kept, std::size_t step,
                              std::size_t largest) {
  const CorrespondenceView view = correspondences.view();
  std::vector<std::uint32_t> rows;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < view.size(); k += step) {
    const Point p = source_point(view, k);
    const Eigen::Vector3d source(p.x, p.y, p.z);  // the working frame has its origin at the centroid
    scatter += source * source.transpose();
    rows.push_back(static_cast<std::uint32_t>(k));
  }
  const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().transpose();
  const auto& centroid = correspondences.source_centroid();
  const Eigen::Vector3d origin = -view.scale() * Eigen::Vector3d(centroid[0], centroid[1], centroid[2]);
  std::array<std::vector<float>, kCoordinates> coordinates;
  for (const std::uint32_t row : rows) {
    const Point p = source_point(view, row);
    const Eigen::Vector3d source(p.x, p.y, p.z);
    const Eigen::Vector3d along = axes * source;
    for (std::size_t c = 0; c < 3; ++c) coordinates[c].push_back(static_cast<float>(along[static_cast<long>(c)]));
    coordinates[position(Coordinate::range)].push_back(static_cast<float>((source - origin).norm()));
    coordinates[position(Coordinate::from_centroid)].push_back(static_cast<float>(source.norm()));
  }
  std::array<Axis, kCoordinates> sorted;
  std::ranges::transform(coordinates, sorted.begin(), axis_of);
  std::vector<Strata> result;
  result.reserve(all_kept.size());
  for (const auto& [shared, count] : all_kept) {
    std::vector<const Axis*> along;
    for (const Coordinate c : std::span(shared).first(count)) along.push_back(&sorted[position(c)]);
    result.push_back(strata_along(along, rows, largest));
  }
  return result;
}

}  // namespace

std::vector<Strata> kept_strata(const Correspondences& correspondences) {
  return strata_by(correspondences, kKept, 1, kStratumRows);
}

std::vector<Strata> sampled_strata(const Correspondences& correspondences) {
  return strata_by(correspondences, kTelling, std::max<std::size_t>(1, correspondences.size() / kSampledRows),
                   kSampledStratumRows);
}

double coherence_length(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound, double least,
                        double most) {
  const auto size = static_cast<std::uint32_t>(view.size());
  const double unit = noise_bound * view.scale();
  const auto explained = [&](std::uint32_t row) {
    return distance(moved(pose, source_point(view, row)), target_point(view, row)) < 2.0 * unit;
  };
  const auto squared_limit = static_cast<float>(kSteps * kStep * unit * kSteps * kStep * unit);
  std::vector<float> squared_apart(size);
  const float* x = view.source(0);
  const float* y = view.source(1);
  const float* z = view.source(2);
  std::array<double, kSteps> agreeing{};
  std::array<double, kSteps> pairs{};
  const std::uint32_t looked_at = std::min(kLookedAt, size);
  for (std::uint32_t l = 0; l < looked_at; ++l) {
    const auto row = static_cast<std::uint32_t>(static_cast<std::uint64_t>(l) * size / looked_at);
    if (explained(row)) continue;
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    for (std::uint32_t other = 0; other < size; ++other) {
      squared_apart[other] = squared(x[other] - p.x, y[other] - p.y, z[other] - p.z);
    }
    for (std::uint32_t other = 0; other < size; ++other) {
      if (squared_apart[other] >= squared_limit || squared_apart[other] == 0.0F || explained(other)) continue;
      const double apart = std::sqrt(static_cast<double>(squared_apart[other])) / unit;
      const std::size_t step = std::min(static_cast<std::size_t>(apart / kStep), kSteps - 1);
      ++pairs[step];
      if (std::abs(distance(q, target_point(view, other)) / unit - apart) < 2.0) ++agreeing[step];
    }
  }
  std::array<double, kSteps> by_chance{};
  for (std::uint32_t k = 0; k < kRandomPairs; ++k) {
    CounterRandom random(kFixedSeed, RandomStage::pairing, k);
    const double apart =
        distance(target_point(view, random.below(size)), target_point(view, random.below(size))) / unit;
    for (std::size_t step = 0; step < kSteps; ++step) {
      const double middle = (static_cast<double>(step) + 0.5) * kStep;
      if (std::abs(apart - middle) < 2.0) ++by_chance[step];
    }
  }
  // Where the lift falls below the limit, between the middles of two steps.
  double length = least / noise_bound;
  double former = std::numeric_limits<double>::infinity();
  for (auto step = static_cast<std::size_t>(length / kStep) - 1; step < kSteps; ++step) {
    if (pairs[step] < kLeastPairs) break;
    const double chance = (by_chance[step] + 1.0) / (kRandomPairs + 2.0);
    const double lift = agreeing[step] / (chance * pairs[step]);
    const double middle = (static_cast<double>(step) + 0.5) * kStep;
    if (lift < kCoherentLift) {
      if (std::isfinite(former)) length = middle - kStep * (kCoherentLift - lift) / (former - lift);
      break;
    }
    length = middle;
    former = lift;
  }
  return std::clamp(length * noise_bound, least, most);
}

}  // namespace consimd::detail
