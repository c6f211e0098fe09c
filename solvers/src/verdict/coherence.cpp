#include "verdict/coherence.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
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
// Rows among which lines are looked for.
constexpr std::size_t kRowsOfLines = 1024;
// Rows that are held against others of their lines, and against how many: of a line of thousands more would hide the
// other lines.
constexpr std::uint32_t kOnLines = 64;
constexpr std::size_t kPartners = 8;
// Supporters that are looked at, where there are more.
constexpr std::size_t kSupportersLookedAt = 96;
// One in so many may lie beside the two lines: a row that supports the pose by chance.
constexpr std::size_t kPointsPerStray = 32;
// Two lines look like more along a direction that is not quite theirs, which their points then tell better.
constexpr std::size_t kMostLines = 16;
constexpr int kRefinements = 2;
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

Eigen::Vector3f vector_of(const Point& p) { return {p.x, p.y, p.z}; }

Eigen::Matrix3f axes_of(const Eigen::Matrix3f& scatter) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(scatter).eigenvectors();
}

// Points on one line along a direction, to within a radius of the first.
struct Line {
  Point first;
  std::vector<Eigen::Vector3f> points;
};

// The lines along a direction that points lie on; the search ends at kMostLines, which are not two, whatever the
// direction's error.
std::vector<Line> lines_along(const Eigen::Vector3f& direction, std::span<const Point> points, float radius) {
  std::vector<Line> lines;
  for (const Point& point : points) {
    const Point place = across(direction, point);
    const auto line = std::ranges::find_if(
        lines, [&](const Line& other) { return squared_distance(other.first, place) < radius * radius; });
    if (line != lines.end()) {
      line->points.push_back(vector_of(point));
    } else if (lines.size() < kMostLines) {
      lines.push_back({place, {vector_of(point)}});
    } else {
      break;
    }
  }
  return lines;
}

// The direction that the points of all lines vary along most.
Eigen::Vector3f refined(const std::vector<Line>& lines) {
  Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
  for (const Line& line : lines) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& point : line.points) sum += point;
    const Eigen::Vector3f mean = sum / static_cast<float>(line.points.size());
    for (const Eigen::Vector3f& point : line.points) scatter += (point - mean) * (point - mean).transpose();
  }
  return axes_of(scatter).col(2);
}

// Whether two of the lines hold the points, but for strays.
bool are_two(const std::vector<Line>& lines, std::size_t points) {
  std::vector<std::size_t> sizes;
  sizes.reserve(lines.size());
  for (const Line& line : lines) sizes.push_back(line.points.size());
  std::ranges::sort(sizes, std::greater<>());
  return sizes.front() + (sizes.size() > 1 ? sizes[1] : 0) + points / kPointsPerStray >= points;
}

// Directions that lines through points may have: the principal axes, and the main direction from each to the nearest
// that is not as near as points of one place are, which is that of lines on a slope.
std::array<Eigen::Vector3f, 4> line_directions(const Eigen::Matrix3Xf& points, float radius) {
  const Eigen::Matrix3Xf centred = points.colwise() - Eigen::Vector3f(points.rowwise().mean());
  Eigen::Matrix3f to_nearest = Eigen::Matrix3f::Zero();
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    Eigen::Vector3f difference = Eigen::Vector3f::Zero();
    float least = std::numeric_limits<float>::infinity();
    for (Eigen::Index other = 0; other < points.cols(); ++other) {
      const Eigen::Vector3f d = points.col(other) - points.col(k);
      const float squared = d.squaredNorm();
      if (squared < radius * radius || squared >= least) continue;
      least = squared;
      difference = d;
    }
    if (std::isfinite(least)) to_nearest += difference * difference.transpose() / least;
  }
  const Eigen::Matrix3f axes = axes_of(centred * centred.transpose());
  return {axes.col(0), axes.col(1), axes.col(2), axes_of(to_nearest).col(2)};
}

// Directions along which supporters of the pose lie on two lines.
std::vector<Eigen::Vector3f> directions_of_two_lines(const CorrespondenceView& view, const WorkingPose& pose,
                                                     double noise_bound, double radius) {
  const std::vector<std::uint32_t> supporters = pose_inliers(view, pose, noise_bound);
  const std::size_t count = std::min(supporters.size(), kSupportersLookedAt);
  std::vector<Eigen::Vector3f> directions;
  if (count == 0) return directions;
  std::vector<Point> points;
  Eigen::Matrix3Xf columns(3, static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    points.push_back(source_point(view, supporters[k * supporters.size() / count]));
    columns.col(static_cast<Eigen::Index>(k)) = vector_of(points[k]);
  }
  const auto reach = static_cast<float>(radius * view.scale());
  for (Eigen::Vector3f direction : line_directions(columns, reach)) {
    std::vector<Line> lines = lines_along(direction, points, reach);
    for (int round = 0; round < kRefinements && lines.size() < kMostLines && !are_two(lines, count); ++round) {
      direction = refined(lines);
      lines = lines_along(direction, points, reach);
    }
    if (are_two(lines, count)) directions.push_back(direction);
  }
  return directions;
}

// Whether rows of a line that the pose misses come together.
bool are_coherent_along(const Eigen::Vector3f& direction, const CorrespondenceView& view, const WorkingPose& pose,
                        double noise_bound, double radius) {
  const std::vector<bool> explained = explained_by(view, pose, noise_bound);
  std::vector<std::uint32_t> rows;
  const std::size_t step = view.size() / kRowsOfLines + 1;
  for (std::size_t row = 0; row < view.size(); row += step) {
    if (!explained[row] && !std::isnan(source_point(view, row).x)) rows.push_back(static_cast<std::uint32_t>(row));
  }
  const auto size = static_cast<std::uint32_t>(rows.size());
  const double reach = radius * view.scale();
  const PointCells lines(size, reach, [&](std::uint32_t k) { return across(direction, source_point(view, rows[k])); });
  const double agreeing = kAgreeing * noise_bound * view.scale();
  double pairs = 0.0;
  double together = 0.0;
  double by_chance = 0.0;
  std::vector<std::uint32_t> partners;
  for (std::uint32_t l = 0; l < std::min(kOnLines, size); ++l) {
    const std::uint32_t row = rows[spread_row(l, size)];
    const Point p = source_point(view, row);
    const Point q = target_point(view, row);
    partners.clear();
    lines.visit(across(direction, p), static_cast<float>(reach * reach), [&](std::uint32_t k, float) {
      if (distance(p, source_point(view, rows[k])) >= reach) partners.push_back(rows[k]);
    });
    const std::size_t count = std::min(partners.size(), kPartners);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t partner = partners[k * partners.size() / count];
      const double apart = distance(p, source_point(view, partner));
      const auto agrees = [&](std::uint32_t other) {
        return std::abs(distance(q, target_point(view, other)) - apart) < agreeing ? 1.0 : 0.0;
      };
      CounterRandom random(kFixedSeed, RandomStage::pairing, static_cast<std::uint32_t>(pairs));
      ++pairs;
      together += agrees(partner);
      by_chance += agrees(rows[random.below(size)]);
    }
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

bool are_on_two_coherent_lines(const CorrespondenceView& view, const WorkingPose& pose, double noise_bound,
                               double radius) {
  return std::ranges::any_of(
      directions_of_two_lines(view, pose, noise_bound, radius),
      [&](const Eigen::Vector3f& direction) { return are_coherent_along(direction, view, pose, noise_bound, radius); });
}

}  // namespace consimd::detail
