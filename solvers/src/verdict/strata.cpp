#include "verdict/strata.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "sampling/counter_random.hpp"
#include "support/points.hpp"

namespace consimd::detail {
namespace {

static_assert(kStratumRows <= 32, "a row's mates are bits of a word");

constexpr std::array<std::uint32_t, kStratumRows> kBits = [] {
  std::array<std::uint32_t, kStratumRows> bits{};
  for (std::size_t j = 0; j < bits.size(); ++j) bits[j] = 1U << j;
  return bits;
}();

// Squared distances of the next kStratumRows points from p, and the bits of those below the limit. The loops are of one
// length, whatever the stratum's: they vectorise.
std::uint32_t closer(const float* x, const float* y, const float* z, const Point& p, float limit,
                     std::array<float, kStratumRows>& squared) {
  for (std::size_t j = 0; j < kStratumRows; ++j) {
    squared[j] = (p.x - x[j]) * (p.x - x[j]) + (p.y - y[j]) * (p.y - y[j]) + (p.z - z[j]) * (p.z - z[j]);
  }
  std::uint32_t bits = 0;
  for (std::size_t j = 0; j < kStratumRows; ++j) bits |= squared[j] < limit ? kBits[j] : 0U;
  return bits;
}

// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

}  // namespace

void add_length(PairingHits& hits, const CorrespondenceView& view, std::uint32_t a, std::uint32_t b, std::uint32_t from,
                std::uint32_t to, double tolerance) {
  if (a == b || from == to || from == a || to == b || (from == b && to == a)) return;
  const double difference = std::abs(distance(source_point(view, a), source_point(view, b)) -
                                     distance(target_point(view, from), target_point(view, to)));
  ++hits.trials;
  for (std::size_t t = 0; t < kTestedBounds.size(); ++t) {
    if (difference < kTestedBounds[t] * tolerance) ++hits.hits[t];
  }
}

Strata::Strata(const CorrespondenceView& view, std::vector<std::uint32_t> rows, std::vector<std::uint32_t> first,
               double apart)
    : view_(view), rows_(std::move(rows)), first_(std::move(first)), mates_(rows_.size()) {
  const auto far = static_cast<float>(apart * view.scale() * apart * view.scale());
  stratum_of_.reserve(rows_.size());
  for (std::vector<float>& coordinate : targets_) coordinate.resize(rows_.size() + kStratumRows);
  std::array<std::array<float, kStratumRows>, 3> sources{};
  std::array<float, kStratumRows> squared{};
  for (std::uint32_t s = 0; s + 1 < first_.size(); ++s) {
    const std::uint32_t size = first_[s + 1] - first_[s];
    stratum_of_.insert(stratum_of_.end(), size, s);
    for (std::uint32_t i = 0; i < size; ++i) {
      const std::uint32_t row = rows_[first_[s] + i];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        targets_[axis][first_[s] + i] = view.target(axis)[row];
        sources[axis][i] = view.source(axis)[row];
      }
    }
    const std::uint32_t all = ~std::uint32_t{0} >> (kStratumRows - size);
    for (std::uint32_t i = 0; i < size; ++i) {
      const Point p{sources[0][i], sources[1][i], sources[2][i]};
      const std::uint32_t near = closer(sources[0].data(), sources[1].data(), sources[2].data(), p, far, squared);
      mates_[first_[s] + i] = all & ~near;
      trials_ += std::popcount(all & ~near);
    }
  }
}

PairingHits Strata::support(const WorkingPose& pose, double bound, const MatchedPoints& matched) const {
  const auto limit = static_cast<float>(bound * view_.scale() * bound * view_.scale());
  std::array<float, kTestedBounds.size()> limits{};
  for (std::size_t b = 0; b < limits.size(); ++b) {
    limits[b] = static_cast<float>(kTestedBounds[b] * kTestedBounds[b]) * limit;
  }
  PairingHits result;
  result.trials = trials_;
  std::array<float, kStratumRows> squared{};
  for (std::uint32_t position = 0; position < rows_.size(); ++position) {
    const std::uint32_t mates = mates_[position];
    const std::size_t begin = first_[stratum_of_[position]];
    const Point p = moved(pose, source_point(view_, rows_[position]));
    std::uint32_t reached =
        mates & closer(&targets_[0][begin], &targets_[1][begin], &targets_[2][begin], p, limit, squared);
    if (reached == 0) continue;
    const double share = 1.0 / std::popcount(mates);
    for (; reached != 0; reached &= reached - 1) {
      const auto j = static_cast<std::size_t>(std::countr_zero(reached));
      if (matched.contains(view_, rows_[position], rows_[begin + j])) continue;
      const float residual = squared[j];
      for (std::size_t b = 0; b < limits.size(); ++b) result.hits[b] += residual < limits[b] ? share : 0.0;
    }
  }
  for (double& hits : result.hits) hits *= result.trials / static_cast<double>(std::max<std::size_t>(rows_.size(), 1));
  return result;
}

PairingHits Strata::lengths(double bound, std::uint32_t pairs) const {
  PairingHits result;
  const auto size = static_cast<std::uint32_t>(rows_.size());
  const double tolerance = 2.0 * bound * view_.scale();
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
    add_length(result, view_, a, b, from, to, tolerance);
  }
  return result;
}

}  // namespace consimd::detail
