#include "verdict/coherence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Eigenvalues>

#include "sampling/counter_random.hpp"
#include "support/point_cells.hpp"
#include "support/points.hpp"
#include "support/pose_candidate.hpp"

namespace consimd::detail {
namespace {

// Steps of the distance in noise bounds, the lift over chance from which correspondences move as one, and how many
// pairs a step needs.
constexpr double kStep = 0.5;
constexpr double kCoherentLift = 2.5;
constexpr double kLeastPairs = 20.0;
// Rows whose neighbours are looked at, and pairs that are enough.
constexpr std::uint32_t kLookedAt = 256;
constexpr std::size_t kEnoughPairs = 1U << 17U;
constexpr std::uint32_t kRandomPairs = 8192;
// Pairs of a line that are enough.
constexpr double kMostOfLines = 2048.0;
// Two lines determine a pose; fourteen more that come into place by an even chance each are less likely than 1e-4.
constexpr std::size_t kFewLines = 16;
// Of many supporters so many are looked at: those of fifteen lines are hardly missed.
constexpr std::size_t kSupportersLookedAt = 96;
// Lengths that differ by less, in noise bounds, agree.
constexpr double kAgreeing = 2.0;
// A row within so many noise bounds of its target is explained.
constexpr double kExplained = 2.0;
// Draws are the same whatever the caller's seed is: a pose has one significance.
constexpr std::uint64_t kFixedSeed = 0;

double middle_of(std::size_t step) { return (static_cast<double>(step) + 0.5) * kStep; }

std::vector<bool> explained_by(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound) {
  std::vector<bool> explained(view.size());
  for (const std::uint32_t row : pose_inliers(view, pose, kExplained * noise_bound)) explained[row] = true;
  return explained;
}

// Rows spread by the golden ratio: however few are looked at, they are from all over.
std::uint32_t spread_row(std::uint32_t l, std::uint32_t size) {
  return static_cast<std::uint32_t>(((l * 0x9E3779B97F4A7C15U) >> 32U) * size >> 32U);
}

Point across(const Eigen::Vector3f& direction, const Point& p) {
  const float position = direction.dot(Eigen::Vector3f(p.x, p.y, p.z));
  return {p.x - position * direction.x(), p.y - position * direction.y(), p.z - position * direction.z()};
}

// Lines along a direction that points lie on, to within a radius: kFewLines at most.
std::size_t count_lines(std::span<const Point> points, const Eigen::Vector3f& direction, float radius) {
  std::vector<Point> lines;
  for (const Point& point : points) {
    const Point place = across(direction, point);
    const auto is_there = [&](const Point& line) { return squared_distance(line, place) < radius * radius; };
    if (std::ranges::any_of(lines, is_there)) continue;
    lines.push_back(place);
    if (lines.size() == kFewLines) break;
  }
  return lines.size();
}

// The principal axis of supporters along which they lie on fewest lines, where that are few.
std::optional<Eigen::Vector3f> few_lines(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                                         double radius) {
  const std::vector<std::uint32_t> supporters = pose_inliers(view, pose, noise_bound);
  const std::size_t count = std::min(supporters.size(), kSupportersLookedAt);
  std::vector<Point> points;
  Eigen::Matrix3Xf columns(3, static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    points.push_back(source_point(view, supporters[k * supporters.size() / count]));
    columns.col(static_cast<Eigen::Index>(k)) << points[k].x, points[k].y, points[k].z;
  }
  if (count == 0) return std::nullopt;
  columns.colwise() -= Eigen::Vector3f(columns.rowwise().mean());
  const Eigen::Matrix3f axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(columns * columns.transpose()).eigenvectors();
  std::optional<Eigen::Vector3f> direction;
  std::size_t fewest = kFewLines;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t lines = count_lines(points, axes.col(axis), static_cast<float>(radius * view.scale()));
    if (lines >= fewest) continue;
    fewest = lines;
    direction = axes.col(axis);
  }
  return direction;
}

// Whether rows of a line that the pose misses come together.
bool are_coherent_along(const Eigen::Vector3f& direction, const CorrespondenceView& view, const WorkingPose& pose,
                        double noise_bound, double radius) {
  const std::vector<bool> explained = explained_by(view, pose, noise_bound);
  std::vector<std::uint32_t> rows;
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    if (!explained[row] && !std::isnan(source_point(view, row).x)) rows.push_back(row);
  }
  const auto size = static_cast<std::uint32_t>(rows.size());
  const double reach = radius * view.scale();
  const PointCells lines(size, reach, [&](std::uint32_t k) { return across(direction, source_point(view, rows[k])); });
  const double agreeing = kAgreeing * noise_bound * view.scale();
  double pairs = 0.0;
  double together = 0.0;
  double by_chance = 0.0;
  for (std::uint32_t l = 0; l < std::min(kLookedAt, size) && pairs < kMostOfLines; ++l) {
    const std::uint32_t row = rows[spread_row(l, size)];
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    lines.visit(across(direction, p), static_cast<float>(reach * reach), [&](std::uint32_t k, float) {
      const double apart = distance(p, source_point(view, rows[k]));
      if (apart < reach) return;
      const auto agrees = [&](std::uint32_t other) {
        return std::abs(distance(q, target_point(view, rows[other])) - apart) < agreeing ? 1.0 : 0.0;
      };
      CounterRandom random(kFixedSeed, RandomStage::pairing, static_cast<std::uint32_t>(pairs));
      ++pairs;
      together += agrees(k);
      by_chance += agrees(random.below(size));
    });
  }
  return pairs >= kLeastPairs && together >= kCoherentLift * (by_chance + 1.0);
}

}  // namespace

Coherence::Coherence(const CorrespondenceView& view, double noise_bound) : view_(view), noise_bound_(noise_bound) {
  const double unit = noise_bound * view.scale();
  const auto size = static_cast<std::uint32_t>(view.size());
  const double reach = static_cast<double>(kSteps) * kStep * unit;
  const auto limit = static_cast<float>(reach * reach);
  const PointCells sources(size, reach, [&](std::uint32_t row) { return source_point(view, row); });
  const std::uint32_t looked_at = std::min(kLookedAt, size);
  for (std::uint32_t l = 0; l < looked_at && pairs_.size() < kEnoughPairs; ++l) {
    const std::uint32_t row = spread_row(l, size);
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    if (std::isnan(p.x)) continue;  // a far row
    sources.visit(p, limit, [&](std::uint32_t other, float squared) {
      if (squared == 0.0F) return;
      const double apart = std::sqrt(static_cast<double>(squared)) / unit;
      const auto step = std::min(static_cast<std::size_t>(apart / kStep), kSteps - 1);
      const bool agrees = std::abs(distance(q, target_point(view, other)) / unit - apart) < kAgreeing;
      pairs_.push_back({row, other, static_cast<std::uint8_t>(step), agrees});
    });
  }
  for (std::uint32_t k = 0; k < kRandomPairs && size > 0; ++k) {
    CounterRandom random(kFixedSeed, RandomStage::pairing, k);
    const double apart =
        distance(target_point(view, random.below(size)), target_point(view, random.below(size))) / unit;
    for (std::size_t step = 0; step < kSteps; ++step) {
      if (std::abs(apart - middle_of(step)) < kAgreeing) ++by_chance_[step];
    }
  }
  for (double& share : by_chance_) share = (share + 1.0) / (kRandomPairs + 2.0);
}

double Coherence::length(const WorkingPose& pose, double least, double most) const {
  const std::vector<bool> explained = explained_by(view_, pose, noise_bound_);
  std::array<double, kSteps> agreeing{};
  std::array<double, kSteps> pairs{};
  for (const Pair& pair : pairs_) {
    if (explained[pair.row] || explained[pair.other]) continue;
    ++pairs[pair.step];
    agreeing[pair.step] += pair.agrees ? 1.0 : 0.0;
  }
  // Where the lift falls below the limit, between the middles of two steps.
  double length = least;
  double former = std::numeric_limits<double>::infinity();
  for (auto step = static_cast<std::size_t>(length / kStep) - 1; step < kSteps; ++step) {
    if (pairs[step] < kLeastPairs) break;
    const double lift = agreeing[step] / (by_chance_[step] * pairs[step]);
    if (lift < kCoherentLift) {
      if (std::isfinite(former)) length = middle_of(step) - kStep * (kCoherentLift - lift) / (former - lift);
      break;
    }
    length = middle_of(step);
    former = lift;
  }
  return std::clamp(length, least, most);
}

std::optional<Eigen::Vector3f> few_coherent_lines(const CorrespondenceView& view, const WorkingPose& pose,
                                                  double noise_bound, double radius) {
  const std::optional<Eigen::Vector3f> along = few_lines(view, pose, noise_bound, radius);
  return along && are_coherent_along(*along, view, pose, noise_bound, radius) ? along : std::nullopt;
}

}  // namespace consimd::detail
