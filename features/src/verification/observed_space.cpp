#include "verification/observed_space.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace consimd::features::detail {
namespace {

// A surface passes near a place that is this many sides of a cube from one of its points along it, and one side across:
// points that are thinned out to one a voxel lie up to 0.87 voxels from where theirs was.
constexpr double kAlong = 1.5;
constexpr double kAcross = 1.0;
// Along an axis, so that the product of three still numbers the cubes; voxel_grid has the same limit.
constexpr double kMostCubes = 0x1p20 + 8.0;
// Places that are looked up together.
constexpr std::size_t kBlock = 64;

std::uint64_t mixed(std::uint64_t key) noexcept {
  // Finaliser of MurmurHash3.
  key = (key ^ (key >> 33)) * 0xff51afd7ed558ccdULL;
  key = (key ^ (key >> 33)) * 0xc4ceb9fe1a85ec53ULL;
  return key ^ (key >> 33);
}

// Cosine of the angle between a normal and the line of sight from which on the side that was seen is known: surfaces
// that are seen at less than some 5 degrees have normals that are further off.
constexpr double kLeastSight = 0.09;

// The table is entered by the low bits of the hash, the filter by the high ones.
std::uint64_t filter_bit(std::uint64_t hash, std::size_t words) noexcept { return (hash >> 32) & (64 * words - 1); }

}  // namespace

SurfaceMap::SurfaceMap(std::vector<SurfacePoint> points, double voxel, double sides)
    : per_side_(1.0 / (sides * voxel)), side_(sides * voxel), points_(std::move(points)) {
  Vector3 high;
  low_.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const SurfacePoint& p : points_) {
    for (std::size_t c = 0; c < 3; ++c) {
      low_[c] = std::min(low_[c], p.point[c]);
      high[c] = std::max(high[c], p.point[c]);
    }
  }
  if (points_.empty()) return;
  for (std::size_t c = 0; c < 3; ++c) {
    low_[c] -= 2.0 * side_;
    const double cubes = (high[c] - low_[c]) * per_side_;
    if (!(cubes < kMostCubes)) {
      throw std::invalid_argument("voxel is " + std::to_string(voxel) + ": the cloud is more than 2^20 of them long");
    }
    cubes_[c] = static_cast<std::int64_t>(cubes) + 3;
  }
  // On a surface a point reaches nine new cubes where one is a voxel's size. There is always room for those of some
  // points more, since half of the table is free before.
  constexpr std::size_t kTogether = 16;
  constexpr std::size_t kLeast = std::bit_ceil(2 * kTogether * kMostReached);
  table_.resize(std::bit_ceil(
      std::max(kLeast, static_cast<std::size_t>(8.0 / (sides * sides) * static_cast<double>(points_.size())))));
  mask_ = table_.size() - 1;
  std::size_t used = 0;
  std::array<Reached, kTogether * kMostReached> reached;
  for (std::size_t begin = 0; begin < points_.size(); begin += kTogether) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < std::min(begin + kTogether, points_.size()); ++i) {
      count += list_reached(static_cast<std::uint32_t>(i), std::span(reached).subspan(count));
    }
    for (const Reached& cube : std::span(reached).first(count)) used += enter(cube) ? 1U : 0U;
    if (2 * used > table_.size()) grow();
  }
  fill_filter();
}

std::size_t SurfaceMap::list_reached(std::uint32_t i, std::span<Reached> reached) const noexcept {
  std::array<std::int64_t, 3> cube;
  // Squares of the distances, in sides, from the point to the centres of the five cubes along each axis.
  std::array<std::array<double, 5>, 3> squares;
  for (std::size_t c = 0; c < 3; ++c) {
    const double place = (points_[i].point[c] - low_[c]) * per_side_;
    cube[c] = static_cast<std::int64_t>(place);
    const double beyond_first = place - static_cast<double>(cube[c]) + 1.5;
    for (std::size_t k = 0; k < 5; ++k) {
      const double along = static_cast<double>(k) - beyond_first;
      squares[c][k] = along * along;
    }
  }
  std::size_t count = 0;
  for (std::size_t z = 0; z < 5; ++z) {
    for (std::size_t y = 0; y < 5; ++y) {
      const double of_row = squares[2][z] + squares[1][y];
      if (of_row > kAlong * kAlong) continue;
      const std::int64_t row =
          ((cube[2] + static_cast<std::int64_t>(z) - 2) * cubes_[1] + cube[1] + static_cast<std::int64_t>(y) - 2) *
              cubes_[0] +
          cube[0] - 2;
      for (std::size_t x = 0; x < 5; ++x) {
        const auto squared = static_cast<float>(of_row + squares[0][x]);
        if (squared > static_cast<float>(kAlong * kAlong)) continue;
        const auto key = static_cast<std::uint64_t>(row + static_cast<std::int64_t>(x));
        const std::uint64_t hash = mixed(key);
        __builtin_prefetch(&table_[hash & mask_]);
        reached[count++] = {key, hash, i, squared};
      }
    }
  }
  return count;
}

bool SurfaceMap::enter(const Reached& cube) noexcept {
  Cube& entry = slot(cube.key, cube.hash);
  const bool was_free = entry.point == kNone;
  if (was_free || cube.squared_distance < entry.squared_distance) {
    entry = {cube.key, cube.point, cube.squared_distance};
  }
  return was_free;
}

void SurfaceMap::grow() {
  std::vector<Cube> old(2 * table_.size());
  old.swap(table_);
  mask_ = table_.size() - 1;
  for (const Cube& entry : old) {
    if (entry.point != kNone) slot(entry.key, mixed(entry.key)) = entry;
  }
}

void SurfaceMap::fill_filter() {
  // One bit in sixteen is set at most.
  filter_.assign(std::max<std::size_t>(table_.size() * 8 / 64, 1), 0);
  for (const Cube& entry : table_) {
    if (entry.point == kNone) continue;
    const std::uint64_t bit = filter_bit(mixed(entry.key), filter_.size());
    filter_[bit / 64] |= std::uint64_t{1} << bit % 64;
  }
}

SurfaceMap::Cube& SurfaceMap::slot(std::uint64_t key, std::uint64_t hash) noexcept {
  std::uint64_t at = hash & mask_;
  while (table_[at].point != kNone && table_[at].key != key) at = (at + 1) & mask_;
  return table_[at];
}

std::optional<std::uint64_t> SurfaceMap::key_of(const Vector3& place) const noexcept {
  std::array<std::int64_t, 3> cube;
  for (std::size_t c = 0; c < 3; ++c) {
    const double along = (place[c] - low_[c]) * per_side_;
    if (!(along >= 0.0 && along < static_cast<double>(cubes_[c]))) return std::nullopt;
    cube[c] = static_cast<std::int64_t>(along);
  }
  return static_cast<std::uint64_t>((cube[2] * cubes_[1] + cube[1]) * cubes_[0] + cube[0]);
}

bool SurfaceMap::may_hold(std::uint64_t hash) const noexcept {
  const std::uint64_t bit = filter_bit(hash, filter_.size());
  return (filter_[bit / 64] >> bit % 64 & 1) != 0;
}

std::uint32_t SurfaceMap::point_of(std::uint64_t key, std::uint64_t at) const noexcept {
  while (table_[at].point != kNone && table_[at].key != key) at = (at + 1) & mask_;
  return table_[at].point;
}

std::uint32_t SurfaceMap::find(const Vector3& place) const noexcept {
  const std::optional<std::uint64_t> key = key_of(place);
  if (!key) return kNone;
  const std::uint64_t hash = mixed(*key);
  return may_hold(hash) ? point_of(*key, hash & mask_) : kNone;
}

double SurfaceMap::offset(const SurfacePoint& surface, const SurfacePoint& place) noexcept {
  return dot({place.point[0] - surface.point[0], place.point[1] - surface.point[1], place.point[2] - surface.point[2]},
             surface.normal);
}

bool SurfaceMap::passes(const SurfacePoint& surface, const SurfacePoint& place) const noexcept {
  return std::abs(offset(surface, place)) <= kAcross * side_ && of_like_orientation(place, surface);
}

Agreement SurfaceMap::agreement(const SurfacePoint& place) const noexcept {
  const std::uint32_t found = find(place.point);
  if (found == kNone) return Agreement::empty;
  return passes(points_[found], place) ? Agreement::surface : Agreement::other;
}

void SurfaceMap::agreements(std::span<const SurfacePoint> places, std::span<Agreement> found) const noexcept {
  // A step is done for a block of places before the next one: its loads do not hang on one another, so that the
  // processor has many of them under way at once.
  struct Asked {
    std::uint64_t key;
    std::uint64_t hash;
    std::uint32_t place;
    std::uint32_t point;
  };
  std::array<Asked, kBlock> asked;
  for (std::size_t begin = 0; begin < places.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, places.size());
    std::size_t within = 0;
    for (std::size_t i = begin; i < end; ++i) {
      found[i] = Agreement::empty;
      if (const std::optional<std::uint64_t> key = key_of(places[i].point)) {
        asked[within++] = {*key, mixed(*key), static_cast<std::uint32_t>(i), kNone};
      }
    }
    std::size_t likely = 0;
    for (std::size_t k = 0; k < within; ++k) {
      const Asked one = asked[k];
      asked[likely] = one;
      likely += may_hold(one.hash) ? 1U : 0U;
    }
    for (std::size_t k = 0; k < likely; ++k) asked[k].point = table_[asked[k].hash & mask_].point;
    for (std::size_t k = 0; k < likely; ++k) {
      if (asked[k].point != kNone) asked[k].point = point_of(asked[k].key, asked[k].hash & mask_);
    }
    for (std::size_t k = 0; k < likely; ++k) {
      const auto& [key, hash, place, point] = asked[k];
      if (point == kNone) continue;
      found[place] = passes(points_[point], places[place]) ? Agreement::surface : Agreement::other;
    }
  }
}

const SurfacePoint* SurfaceMap::surface_at(const SurfacePoint& place) const noexcept {
  const std::uint32_t found = find(place.point);
  return found != kNone && passes(points_[found], place) ? &points_[found] : nullptr;
}

double SurfaceMap::squared_distance(const SurfacePoint& place) const noexcept {
  const SurfacePoint* const surface = surface_at(place);
  if (surface == nullptr) return 1.0;
  const double sides = offset(*surface, place) * per_side_;
  return sides * sides;
}

FreeSpace::FreeSpace(const Cloud& scan, const Vector3& viewpoint, double margin)
    : viewpoint_(viewpoint), margin_(margin) {
  // As fine as leaves two points or more in a cell on average: an empty cell among seen ones tells nothing.
  constexpr std::size_t kFinest = 128;
  constexpr std::size_t kCoarsest = 16;
  edge_ = kFinest;
  std::vector<Direction> points(scan.size());
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = direction(scan.point(i));
    farthest = std::max(farthest, points[i].squared_range);
  }
  // From so far away ranges, which are floats, do not tell what lies before what.
  if (!(std::sqrt(farthest) * std::numeric_limits<float>::epsilon() < margin)) {
    edge_ = 0;
    return;
  }
  for (;;) {
    look(points);
    const auto seen = static_cast<std::size_t>(std::ranges::count_if(range_, [](float r) { return r > 0.0f; }));
    if (2 * seen <= points.size()) break;
    // Four cells become one. Edges are powers of two, so that a direction rounds to the cell that it would have had.
    if (edge_ == kCoarsest) {
      edge_ = 0;
      return;
    }
    for (Direction& point : points) {
      const std::size_t column = point.cell % edge_;
      const std::size_t row = point.cell / edge_;  // of all faces
      point.cell = row / 2 * (edge_ / 2) + column / 2;
    }
    edge_ /= 2;
  }
  if (hides_much(points)) {
    edge_ = 0;
    return;
  }
  reach_to_the_nearest_beside();
}

bool FreeSpace::hides_much(const std::vector<Direction>& points) const {
  // Where a scan is taken as seen from its viewpoint, 2 to 21 % of its points lie behind others in the same cell; where
  // it is taken as seen from 3 times its spread beside that, 35 to 94 % do.
  constexpr double kMostHidden = 1.0 / 3.0;
  std::size_t hidden = 0;
  for (const Direction& seen : points) {
    const double free = static_cast<double>(range_[seen.cell]) + margin_;
    hidden += seen.squared_range > free * free ? std::size_t{1} : std::size_t{0};
  }
  return static_cast<double>(hidden) > kMostHidden * static_cast<double>(points.size());
}

void FreeSpace::reach_to_the_nearest_beside() {
  const std::vector<float> nearest = range_;
  const auto last = static_cast<std::ptrdiff_t>(edge_) - 1;
  for (std::size_t cell = 0; cell < nearest.size(); ++cell) {
    if (nearest[cell] == 0.0f) continue;
    const std::size_t face = cell / (edge_ * edge_) * edge_ * edge_;
    const auto row = static_cast<std::ptrdiff_t>((cell - face) / edge_);
    const auto column = static_cast<std::ptrdiff_t>((cell - face) % edge_);
    for (std::ptrdiff_t r = std::max<std::ptrdiff_t>(row - 1, 0); r <= std::min(row + 1, last); ++r) {
      for (std::ptrdiff_t c = std::max<std::ptrdiff_t>(column - 1, 0); c <= std::min(column + 1, last); ++c) {
        const float beside = nearest[face + static_cast<std::size_t>(r) * edge_ + static_cast<std::size_t>(c)];
        if (beside > 0.0f) range_[cell] = std::min(range_[cell], beside);
      }
    }
  }
}

FreeSpace::Direction FreeSpace::direction(const Vector3& place) const noexcept {
  const double x = place[0] - viewpoint_[0];
  const double y = place[1] - viewpoint_[1];
  const double z = place[2] - viewpoint_[2];
  // The face that the ray leaves the cube by, and the ray's components along and across it.
  std::size_t face = 0;
  double out = x;
  double across = y;
  double down = z;
  if (std::abs(y) > std::abs(out)) {
    face = 2;
    out = y;
    across = z;
    down = x;
  }
  if (std::abs(z) > std::abs(out)) {
    face = 4;
    out = z;
    across = x;
    down = y;
  }
  if (!(std::abs(out) > 0.0)) return {};
  face += out < 0.0 ? std::size_t{1} : std::size_t{0};
  const double half = 0.5 * static_cast<double>(edge_);
  const double per_length = half / std::abs(out);
  const auto cell = [&](double component) {
    return std::min(static_cast<std::size_t>(static_cast<std::int64_t>(component * per_length + half)), edge_ - 1);
  };
  return {(face * edge_ + cell(across)) * edge_ + cell(down), x * x + y * y + z * z};
}

void FreeSpace::look(const std::vector<Direction>& points) {
  range_.assign(6 * edge_ * edge_, 0.0f);
  for (const Direction& seen : points) {
    const auto range = static_cast<float>(std::sqrt(seen.squared_range));
    float& nearest = range_[seen.cell];
    if (range > 0.0f && (nearest == 0.0f || range < nearest)) nearest = range;
  }
}

std::uint32_t FreeSpace::count_seen_through(std::span<const SurfacePoint> places) const noexcept {
  if (edge_ == 0) return 0;
  // As in SurfaceMap::agreements: all directions of a block, then their ranges.
  std::array<Direction, kBlock> directions;
  std::uint32_t count = 0;
  for (std::size_t begin = 0; begin < places.size(); begin += kBlock) {
    const std::span<const SurfacePoint> block = places.subspan(begin, std::min(kBlock, places.size() - begin));
    for (std::size_t k = 0; k < block.size(); ++k) directions[k] = direction(block[k].point);
    for (const Direction& seen : std::span(directions).first(block.size())) {
      const double free = static_cast<double>(range_[seen.cell]) - margin_;
      count += free > 0.0 && free * free > seen.squared_range ? 1U : 0U;
    }
  }
  return count;
}

bool FreeSpace::sees(const Vector3& point) const noexcept {
  if (edge_ == 0) return false;
  const Direction seen = direction(point);
  const double reach = static_cast<double>(range_[seen.cell]) + margin_;
  return seen.squared_range <= reach * reach;
}

std::vector<SurfacePoint> surface_points(const CellGrid& surfaces, const FreeSpace& space) {
  const Cloud& cloud = surfaces.cloud();
  const CloudView view = cloud.view();
  const std::optional<Vector3> viewpoint = space.viewpoint();
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < view.size() && view.has_normals(); ++i) {
    SurfacePoint p{cloud.point(i), {view.normals(0)[i], view.normals(1)[i], view.normals(2)[i]}};
    if (!std::isfinite(p.normal[0])) continue;
    if (viewpoint) {
      const double cosine = vector(p.normal).dot((vector(*viewpoint) - vector(p.point)).normalized());
      if (cosine < 0.0) {
        for (double& x : p.normal) x = -x;
      }
      p.has_front = std::abs(cosine) >= kLeastSight && space.sees(p.point);
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace consimd::features::detail
