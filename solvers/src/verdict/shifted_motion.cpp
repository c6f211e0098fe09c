#include "verdict/shifted_motion.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <vector>

#include <consimd/kernels/elementary_functions.hpp>

#include "support/cell_keys.hpp"
#include "support/points.hpp"
#include "verdict/false_poses.hpp"

namespace consimd::detail {
namespace {

// Rows are gathered in cells of two noise bounds; what agrees may be cut by their faces, so the means of the fullest
// are moved to where the rows about them are.
constexpr double kCell = 2.0;
constexpr std::size_t kStarts = 16;
constexpr int kMoves = 3;

// What the pose leaves of a row: its target less the moved source, and the cell that this lies in.
struct Rest {
  std::uint64_t cell;
  std::uint32_t row;
  Point vector;
};

std::vector<Rest> rests(const CorrespondenceView& view, const BestPoses& poses, double bound) {
  const auto near = static_cast<float>(kNearMisses * bound * kNearMisses * bound);
  std::vector<Rest> result;
  result.reserve(view.size());
  for (std::uint32_t row = 0; row < view.size(); ++row) {
    const Point p = moved(poses.best().pose, source_point(view, row));
    const Point q = target_point(view, row);
    if (!(squared_distance(p, q) >= near)) continue;  // a far row is not a number
    const Point d{q.x - p.x, q.y - p.y, q.z - p.z};
    result.push_back({cell_key(d, kCell * bound), row, d});
  }
  std::ranges::sort(result,
                    [](const Rest& a, const Rest& b) { return std::tie(a.cell, a.row) < std::tie(b.cell, b.row); });
  return result;
}

Point mean(const std::vector<Rest>& rests, std::size_t begin, std::size_t end) {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    x += rests[k].vector.x;
    y += rests[k].vector.y;
    z += rests[k].vector.z;
  }
  const auto count = static_cast<double>(end - begin);
  return {static_cast<float>(x / count), static_cast<float>(y / count), static_cast<float>(z / count)};
}

// Runs of rests in one cell.
struct Run {
  std::size_t begin;
  std::size_t end;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

std::vector<Run> fullest_cells(const std::vector<Rest>& rests) {
  std::vector<Run> runs;
  for (std::size_t begin = 0; begin < rests.size();) {
    std::size_t end = begin;
    while (end < rests.size() && rests[end].cell == rests[begin].cell) ++end;
    if (end - begin > 1) runs.push_back({begin, end});
    begin = end;
  }
  std::ranges::stable_sort(runs, std::ranges::greater{}, &Run::size);
  if (runs.size() > kStarts) runs.resize(kStarts);
  return runs;
}

WorkingPose shifted_by(WorkingPose pose, const Point& shift) {
  pose.translation[0] += shift.x;
  pose.translation[1] += shift.y;
  pose.translation[2] += shift.z;
  return pose;
}

}  // namespace

RepeatedMotions shifted_motions(const Correspondences& correspondences, const BestPoses& poses, double noise_bound) {
  const CorrespondenceView view = correspondences.view();
  const double bound = noise_bound * view.scale();
  const std::vector<Rest> all = rests(view, poses, bound);
  const auto limit = static_cast<float>(bound * bound);
  RepeatedMotions result;
  std::vector<Point> shifts;
  std::vector<Rest> about;
  for (const Run& run : fullest_cells(all)) {
    Point shift = mean(all, run.begin, run.end);
    for (int move = 0; move < kMoves; ++move) {
      about.clear();
      std::ranges::copy_if(all, std::back_inserter(about),
                           [&](const Rest& rest) { return squared_distance(rest.vector, shift) < limit; });
      if (about.empty()) break;
      shift = mean(about, 0, about.size());
    }
    // Cells that share a shift end at the same one.
    const bool is_new = std::ranges::none_of(
        shifts, [&](const Point& former) { return squared_distance(former, shift) < kCell * kCell * limit; });
    if (about.size() < 3 || !is_new) continue;
    shifts.push_back(shift);
    const WorkingPose pose = shifted_by(poses.best().pose, shift);
    result.independent.push_back(independent_support(view, pose, noise_bound));
    const PoseCandidate found = scored(view, pose, noise_bound);
    if (found.support.count >= 3 && found.support.score > result.best.support.score) result.best = found;
  }
  std::ranges::sort(result.independent, std::ranges::greater{});
  if (result.best.support.count >= 3) result.best = locally_optimise(correspondences, result.best, noise_bound);
  return result;
}

double log_chance_of(const RepeatedMotions& motions, double size, double chance) {
  const std::vector<double>& independent = motions.independent;
  const double told_by_row = motions.looked_at ? 0.0 : 1.0;
  double least = 0.0;
  for (std::size_t m = 0; m < independent.size(); ++m) {
    const double rows = independent[m];
    const double all = motions.looked_at.value_or(size);
    const double different = motions.looked_at.value_or(size / rows);
    const double expected =
        different * elementary::exp(log_binomial_tail(size - told_by_row, rows - told_by_row, chance));
    least = std::min(least, log_binomial_tail(all, static_cast<double>(m + 1), std::min(expected / all, 1.0)));
  }
  return std::min(0.0, least + elementary::log(std::max(static_cast<double>(independent.size()), 1.0)));
}

}  // namespace consimd::detail
