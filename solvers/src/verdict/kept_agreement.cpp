#include "verdict/kept_agreement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/points.hpp"
#include "verdict/kept_coordinates.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {
namespace {

// Mismatched pairs that are looked at.
constexpr std::size_t kPairs = 1U << 17U;
// Rows that keep a coordinate by chance alone once in so many times show nothing: one in a hundred for all kinds.
constexpr double kNothingKept = 1e-3;
// The share of the rows. What fewer keep may be another motion's: an object that is its own image when turned keeps
// heights and ranges; or patches that keep one together, and say too much of all else.
constexpr double kNearlyAll = 0.9;

// Coordinates of a point, by its row, coordinate by coordinate.
using Columns = std::array<std::vector<float>, kCoordinates>;

// Sets of coordinates as bits, and how often each is the set of those kept.
constexpr std::size_t kSets = 1U << kCoordinates;
using SetCounts = std::array<double, kSets>;

std::size_t bits_of(const Kept& kept) {
  std::size_t bits = 0;
  for (const Coordinate c : kept.all()) bits |= std::size_t{1} << index_of(c);
  return bits;
}

double count_with(const SetCounts& counts, std::size_t bits) {
  double sum = 0.0;
  for (std::size_t set = 0; set < kSets; ++set) sum += (set & bits) == bits ? counts[set] : 0.0;
  return sum;
}

Point moved_back(const WorkingPose& pose, const Point& q) {
  const float x = q.x - pose.translation[0];
  const float y = q.y - pose.translation[1];
  const float z = q.z - pose.translation[2];
  const float* r = pose.rotation;
  return {r[0] * x + r[3] * y + r[6] * z, r[1] * x + r[4] * y + r[7] * z, r[2] * x + r[5] * y + r[8] * z};
}

// What is kept by the rows that the pose misses, and by mismatched pairs of a source and a target.
class Agreement {
 public:
  Agreement(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound, double reach)
      : view_(correspondences.view()),
        pose_(pose),
        limit_(static_cast<float>(reach * view_.scale())),
        near_(kNearMisses * noise_bound * view_.scale()) {
    const SourceCoordinates coordinates_of(correspondences, 1);
    for (std::size_t row = 0; row < view_.size(); ++row) {
      const auto source = coordinates_of(source_point(view_, row));
      const auto target = coordinates_of(moved_back(pose, target_point(view_, row)));
      for (std::size_t c = 0; c < kCoordinates; ++c) {
        sources_[c].push_back(source[c]);
        targets_[c].push_back(target[c]);
      }
    }
  }

  [[nodiscard]] SetCounts missed_rows() const {
    SetCounts counts{};
    for (std::size_t row = 0; row < view_.size(); ++row) {
      if (residual(row, row) >= near_) ++counts[kept_by(row, row)];
    }
    return counts;
  }

  struct Pairs {
    SetCounts kept{};
    PairingHits reached;
  };
  [[nodiscard]] Pairs pairs(const MatchedPoints& matched) const {
    Pairs result;
    const std::size_t size = view_.size();
    const std::size_t shifts = std::clamp<std::size_t>(kPairs / size, 1, size - 1);
    for (std::size_t s = 0; s < shifts; ++s) {
      const std::size_t shift = 1 + s * (size - 1) / shifts;
      for (std::size_t row = 0; row < size; ++row) {
        const std::size_t other = row + shift < size ? row + shift : row + shift - size;
        const std::size_t set = kept_by(row, other);
        ++result.kept[set];
        if (set + 1 == kSets) add_if_reached(row, other, matched, result.reached);
      }
    }
    result.reached.trials = static_cast<double>(shifts * size);
    return result;
  }

 private:
  void add_if_reached(std::size_t row, std::size_t other, const MatchedPoints& matched, PairingHits& hits) const {
    const double residual = this->residual(row, other);
    if (residual >= static_cast<double>(limit_) ||
        distance(source_point(view_, row), source_point(view_, other)) < near_ || matched.contains(view_, row, other)) {
      return;
    }
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      hits.hits[b] += residual < kTestedBounds[b] * static_cast<double>(limit_) ? 1.0 : 0.0;
    }
  }

  [[nodiscard]] double residual(std::size_t source, std::size_t target) const {
    return distance(moved(pose_, source_point(view_, source)), target_point(view_, target));
  }

  [[nodiscard]] std::size_t kept_by(std::size_t source, std::size_t target) const {
    std::size_t set = 0;
    for (std::size_t c = 0; c < kCoordinates; ++c) {
      set |= static_cast<std::size_t>(std::abs(sources_[c][source] - targets_[c][target]) < limit_) << c;
    }
    return set;
  }

  CorrespondenceView view_;
  const WorkingPose& pose_;
  float limit_;  // working frame
  double near_;
  Columns sources_;
  Columns targets_;
};

}  // namespace

std::vector<Chances> kept_chances(const Correspondences& correspondences, const WorkingPose& pose, double noise_bound,
                                  double reach, const Chances& at_random, const MatchedPoints& matched) {
  const Agreement agreement(correspondences, pose, noise_bound, reach);
  const SetCounts missed = agreement.missed_rows();
  const double all = count_with(missed, 0);
  std::vector<std::size_t> kept_by_nearly_all;
  for (const Kept& kept : kKept) {
    const std::size_t bits = bits_of(kept);
    if (all > 0.0 && count_with(missed, bits) >= kNearlyAll * all) kept_by_nearly_all.push_back(bits);
  }
  std::vector<Chances> result;
  if (kept_by_nearly_all.empty()) return result;
  const Agreement::Pairs pairs = agreement.pairs(matched);
  for (const std::size_t bits : kept_by_nearly_all) {
    const double rows = count_with(missed, bits);
    const double of_pairs = count_with(pairs.kept, bits);
    const double by_chance = chance(of_pairs, pairs.reached.trials);
    if (log_binomial_tail(all, rows, by_chance) > elementary::log(kNothingKept)) continue;
    Chances chances = at_random;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      const double given_kept = correspondences.size() <= kFewCorrespondences
                                    ? chance(pairs.reached.hits[b], of_pairs)
                                    : std::min(1.0, at_random.support[b] / by_chance);
      chances.support[b] = std::max(at_random.support[b], rows / all * given_kept);
    }
    result.push_back(chances);
  }
  return result;
}

}  // namespace consimd::detail
