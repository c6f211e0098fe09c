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

// Trials are counted at each such row, and are about as many at the others.
constexpr std::uint32_t kCountedStep = 8;

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

Strata::Strata(const CorrespondenceView& view, Partition partition, double apart)
    : view_(view),
      rows_(std::move(partition.rows)),
      first_(std::move(partition.first)),
      apart_(static_cast<float>(apart * view.scale() * apart * view.scale())) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sources_[axis].resize(rows_.size() + kStratumRows);
    targets_[axis].resize(rows_.size() + kStratumRows);
    for (std::size_t position = 0; position < rows_.size(); ++position) {
      sources_[axis][position] = view.source(axis)[rows_[position]];
      targets_[axis][position] = view.target(axis)[rows_[position]];
    }
  }
  stratum_of_.reserve(rows_.size());
  for (std::uint32_t s = 0; s + 1 < first_.size(); ++s) {
    stratum_of_.insert(stratum_of_.end(), first_[s + 1] - first_[s], s);
  }
  position_.resize(view.size());
  stratum_of_row_.resize(view.size());
  for (std::uint32_t position = 0; position < rows_.size(); ++position) {
    position_[rows_[position]] = position;
    stratum_of_row_[rows_[position]] = stratum_of_[position];
  }
  double looked_at = 0.0;
  for (std::uint32_t position = 0; position < rows_.size(); position += kCountedStep) {
    trials_ += std::popcount(mates(position));
    ++looked_at;
  }
  trials_ *= static_cast<double>(rows_.size()) / std::max(looked_at, 1.0);
}

std::uint32_t Strata::mates(std::uint32_t position) const {
  const std::uint32_t begin = first_[stratum_of_[position]];
  const std::uint32_t size = first_[stratum_of_[position] + 1] - begin;
  const Point p{sources_[0][position], sources_[1][position], sources_[2][position]};
  std::array<float, kStratumRows> squared{};
  const std::uint32_t near = closer(&sources_[0][begin], &sources_[1][begin], &sources_[2][begin], p, apart_, squared);
  return (~std::uint32_t{0} >> (kStratumRows - size)) & ~near;
}

PairingHits Strata::support(const WorkingPose& pose, double bound, const MatchedPoints& matched) const {
  const Limits limits = this->limits(bound);
  PairingHits result;
  std::array<float, kStratumRows> squared{};
  for (std::uint32_t position = 0; position < rows_.size(); ++position) {
    const std::size_t begin = first_[stratum_of_[position]];
    const Point p = moved(pose, source_point(view_, rows_[position]));
    std::uint32_t reached =
        closer(&targets_[0][begin], &targets_[1][begin], &targets_[2][begin], p, limits.front(), squared);
    if (reached == 0) continue;
    const std::uint32_t mates = this->mates(position);
    reached &= mates;
    if (reached == 0) continue;
    const double share = 1.0 / std::popcount(mates);
    for (; reached != 0; reached &= reached - 1) {
      const auto j = static_cast<std::size_t>(std::countr_zero(reached));
      if (matched.contains(view_, rows_[position], rows_[begin + j])) continue;
      add(result, share, squared[j], limits);
    }
  }
  return mean(result);
}

PairingHits Strata::support(std::span<const ReachedTarget> reached, double bound, const MatchedPoints& matched) const {
  const Limits limits = this->limits(bound);
  PairingHits result;
  for (const auto& [source_row, target_row, squared] : reached) {
    if (stratum_of_row_[source_row] != stratum_of_row_[target_row] ||
        squared_distance(source_point(view_, source_row), source_point(view_, target_row)) < apart_ ||
        matched.contains(view_, source_row, target_row)) {
      continue;
    }
    add(result, 1.0 / std::popcount(mates(position_[source_row])), squared, limits);
  }
  return mean(result);
}

Strata::Limits Strata::limits(double bound) const {
  const auto limit = static_cast<float>(bound * view_.scale() * bound * view_.scale());
  Limits result{};
  for (std::size_t b = 0; b < result.size(); ++b) {
    result[b] = static_cast<float>(kTestedBounds[b] * kTestedBounds[b]) * limit;
  }
  return result;
}

void Strata::add(PairingHits& hits, double share, float squared, const Limits& limits) {
  for (std::size_t b = 0; b < limits.size(); ++b) hits.hits[b] += squared < limits[b] ? share : 0.0;
}

PairingHits Strata::mean(PairingHits hits) const {
  hits.trials = trials_;
  for (double& at_bound : hits.hits) at_bound *= trials_ / static_cast<double>(std::max<std::size_t>(rows_.size(), 1));
  return hits;
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
