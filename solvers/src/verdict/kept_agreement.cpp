#include "verdict/kept_agreement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include <Eigen/Eigenvalues>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/points.hpp"
#include "verdict/kept_coordinates.hpp"
#include "verdict/pairing_chances.hpp"
#include "verdict/pose_checks.hpp"
#include "verdict/strata.hpp"

namespace consimd::detail {
namespace {

// Mismatched pairs that are looked at.
constexpr std::size_t kPairs = 1U << 17U;
// The share of the rows. What fewer keep may be another motion's: an object that is its own image when turned keeps
// heights and ranges; or patches that keep one together, and say too much of all else.
constexpr double kNearlyAll = 0.9;
// Rows that keep a coordinate by chance alone once in so many times show nothing: one in a hundred for all kinds.
constexpr double kNothingKept = 1e-3;

// The coordinates of a source, and what rows keep best: an axis of the sources is not quite the height where a few
// poles make it lean, nor is its image under a pose of few supporters.
constexpr std::size_t kBest = kCoordinates;
constexpr std::size_t kCompared = kCoordinates + 1;
// Rows that this may have been chosen for: by two directions and an offset.
constexpr double kChosenFor = 5.0;
// And rows that the viewpoint of a range may have been: see kept_viewpoint.
constexpr double kViewpointChosenFor = 3.0;
// Fewer mismatched pairs that keep the same hardly tell how many of them a pose reaches: by Laplace's rule one in ten
// or more, whatever it is.
constexpr double kTellingPairs = 8.0;
// The cosine of the angle by which a pose may lean.
constexpr double kLean = 1.0 - 0.5 * kLargestRotationDeviation * kLargestRotationDeviation;
// Coordinates of a point, by its row, coordinate by coordinate.
using Columns = std::array<std::vector<float>, kCompared>;

// Sets of coordinates as bits, and how often each is the set of those kept, to within each of the tested bounds: where
// rows keep a coordinate better than the bound asks, a narrower one is reached as easily along it.
constexpr std::size_t kSets = 1U << kCompared;
constexpr std::size_t kBestOnly = std::size_t{1} << kBest;
constexpr std::size_t kBestAndRange = kBestOnly | std::size_t{1} << index_of(Coordinate::range);
using SetCounts = std::array<std::array<double, kSets>, kTestedBounds.size()>;

std::size_t bits_of(const Kept& kept) {
  std::size_t bits = 0;
  for (const Coordinate c : kept.all()) bits |= std::size_t{1} << index_of(c);
  return bits;
}

// Rows that a set of coordinates may have been chosen for.
double chosen_for(std::size_t bits) {
  return bits == kBestAndRange ? kChosenFor + kViewpointChosenFor : bits == kBestOnly ? kChosenFor : 0.0;
}

// How often all of a set were kept, at each of the tested bounds.
std::array<double, kTestedBounds.size()> counts_with(const SetCounts& counts, std::size_t bits) {
  std::array<double, kTestedBounds.size()> sums{};
  for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
    for (std::size_t set = 0; set < kSets; ++set) sums[b] += (set & bits) == bits ? counts[b][set] : 0.0;
  }
  return sums;
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
    const KeptBest best = kept_best();
    directions_.fill(Eigen::Vector3f::Zero());
    for (const Coordinate c : {Coordinate::least, Coordinate::middle, Coordinate::greatest}) {
      directions_[index_of(c)] = coordinates_of.axis(c);
    }
    directions_[kBest] = best.of_source;
    const auto along = [](const Eigen::Vector3f& direction, const Point& p) {
      return direction.dot(Eigen::Vector3f(p.x, p.y, p.z));
    };
    for (std::size_t row = 0; row < view_.size(); ++row) {
      const Point source = source_point(view_, row);
      const Point target = moved_back(pose, target_point(view_, row));
      const auto of_source = coordinates_of(source);
      const auto of_target = coordinates_of(target);
      for (std::size_t c = 0; c < kCoordinates; ++c) {
        sources_[c].push_back(of_source[c]);
        targets_[c].push_back(of_target[c]);
      }
      sources_[kBest].push_back(along(best.of_source, source));
      targets_[kBest].push_back(along(best.of_target, target) - best.offset);
    }
  }

  // Along which a set of coordinates tells positions.
  [[nodiscard]] std::vector<Eigen::Vector3f> directions(std::size_t bits) const {
    std::vector<Eigen::Vector3f> result;
    for (std::size_t c = 0; c < kCompared; ++c) {
      if ((bits >> c & 1U) != 0 && !directions_[c].isZero()) result.push_back(directions_[c]);
    }
    return result;
  }

  [[nodiscard]] bool has_best() const { return !directions_[kBest].isZero(); }

  [[nodiscard]] SetCounts missed_rows() const {
    SetCounts counts{};
    for (std::size_t row = 0; row < view_.size(); ++row) {
      if (residual(row, row) >= near_) add_kept(row, row, counts);
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
        // Near misses of a true pose.
        if (distance(source_point(view_, row), source_point(view_, other)) < near_) continue;
        ++result.reached.trials;
        const std::size_t set = add_kept(row, other, result.kept);
        if ((set | kBestOnly) + 1 == kSets) add_if_reached(row, other, matched, result.reached);
      }
    }
    return result;
  }

 private:
  // The position of the source along one direction and of the target along another whose difference varies least among
  // the rows that the pose misses. In the source's frame; zero where the pose does not bring one direction to the
  // other.
  struct KeptBest {
    Eigen::Vector3f of_source = Eigen::Vector3f::Zero();
    Eigen::Vector3f of_target = Eigen::Vector3f::Zero();
    float offset = 0.0F;  // of the target's position from the source's
  };
  [[nodiscard]] KeptBest kept_best() const {
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    Vector6d sum = Vector6d::Zero();
    Eigen::Matrix<double, 6, 6> scatter = Eigen::Matrix<double, 6, 6>::Zero();
    double count = 0.0;
    for (std::size_t row = 0; row < view_.size(); ++row) {
      if (!(residual(row, row) >= near_)) continue;
      const Point p = source_point(view_, row);
      const Point q = moved_back(pose_, target_point(view_, row));
      const Vector6d both{p.x, p.y, p.z, -q.x, -q.y, -q.z};
      sum += both;
      scatter += both * both.transpose();
      ++count;
    }
    if (count <= kChosenFor) return {};
    scatter -= sum * sum.transpose() / count;
    const Vector6d least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>>(scatter).eigenvectors().col(0);
    const Eigen::Vector3d of_source = least.head<3>().normalized();
    const Eigen::Vector3d of_target = least.tail<3>().normalized();
    if (!(of_source.dot(of_target) > kLean)) return {};
    const double offset = -(of_source.dot(sum.head<3>()) + of_target.dot(sum.tail<3>())) / count;
    return {of_source.cast<float>(), of_target.cast<float>(), static_cast<float>(offset)};
  }

  void add_if_reached(std::size_t row, std::size_t other, const MatchedPoints& matched, PairingHits& hits) const {
    const double residual = this->residual(row, other);
    if (residual >= static_cast<double>(limit_) || matched.contains(view_, row, other)) return;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      hits.hits[b] += residual < kTestedBounds[b] * static_cast<double>(limit_) ? 1.0 : 0.0;
    }
  }

  [[nodiscard]] double residual(std::size_t source, std::size_t target) const {
    return distance(moved(pose_, source_point(view_, source)), target_point(view_, target));
  }

  // Counts the sets of coordinates that a source and a target share, and returns that of the widest bound.
  std::size_t add_kept(std::size_t source, std::size_t target, SetCounts& counts) const {
    std::array<float, kCompared> apart{};
    for (std::size_t c = 0; c < kCompared; ++c) apart[c] = std::abs(sources_[c][source] - targets_[c][target]);
    std::array<std::size_t, kTestedBounds.size()> sets{};
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      const float limit = static_cast<float>(kTestedBounds[b]) * limit_;
      for (std::size_t c = 0; c < kCompared; ++c) sets[b] |= static_cast<std::size_t>(apart[c] < limit) << c;
      ++counts[b][sets[b]];
    }
    return sets.front();
  }

  CorrespondenceView view_;
  const WorkingPose& pose_;
  float limit_;  // working frame
  double near_;
  std::array<Eigen::Vector3f, kCompared> directions_;  // zero where a coordinate is no position along one
  Columns sources_;
  Columns targets_;
};

}  // namespace

std::vector<KeptChances> kept_chances(const Correspondences& correspondences, const WorkingPose& pose,
                                      double noise_bound, double reach, const Chances& at_random,
                                      const MatchedPoints& matched) {
  const Agreement agreement(correspondences, pose, noise_bound, reach);
  const SetCounts missed = agreement.missed_rows();
  const double all = counts_with(missed, 0).front();
  std::vector<std::size_t> sets;
  std::ranges::transform(kKept, std::back_inserter(sets), bits_of);
  if (agreement.has_best()) sets.insert(sets.end(), {kBestOnly, kBestAndRange});
  std::erase_if(
      sets, [&](std::size_t bits) { return !(all > 0.0 && counts_with(missed, bits).front() >= kNearlyAll * all); });
  std::vector<KeptChances> result;
  if (sets.empty()) return result;
  const Agreement::Pairs pairs = agreement.pairs(matched);
  for (const std::size_t bits : sets) {
    const auto rows = counts_with(missed, bits);
    const auto of_pairs = counts_with(pairs.kept, bits);
    const double by_chance = chance(of_pairs.front(), pairs.reached.trials);
    const double chosen = chosen_for(bits);
    const bool is_chance =
        log_binomial_tail(all - chosen, rows.front() - chosen, by_chance) > elementary::log(kNothingKept);
    if (is_chance || of_pairs.front() < kTellingPairs) continue;
    Chances chances = at_random;
    double of_larger_bound = 1.0;
    for (std::size_t b = 0; b < kTestedBounds.size(); ++b) {
      const double given_kept = correspondences.size() <= kFewCorrespondences
                                    ? chance(pairs.reached.hits[b], of_pairs[b])
                                    : at_random.support[b] / chance(of_pairs[b], pairs.reached.trials);
      of_larger_bound = std::min(of_larger_bound, rows[b] / all * std::min(1.0, given_kept));
      chances.support[b] = std::max(at_random.support[b], of_larger_bound);
    }
    result.push_back({chances, agreement.directions(bits)});
  }
  return result;
}

}  // namespace consimd::detail
