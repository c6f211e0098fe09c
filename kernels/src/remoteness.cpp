#include "remoteness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace consimd::detail {
namespace {

// Pairs of points whose distances tell the size of the bulk: with far rows in the minority, two points of four or more
// pairs in ten are none. The tenth part of the distances is about a third of the median distance from the middle.
constexpr std::size_t kPairs = 64;
constexpr std::size_t kClosePairs = kPairs / 10;
constexpr double kStandsOut = 24.0;
constexpr std::size_t kProvesNoPose = 3;  // places

using Point = std::array<double, 3>;

double distance(const Point& p, const Point& from) {
  return std::max({std::abs(p[0] - from[0]), std::abs(p[1] - from[1]), std::abs(p[2] - from[2])});
}

template <typename Points>
Point point(const Points& points, std::size_t i) {
  return {static_cast<double>(points(i, 0)), static_cast<double>(points(i, 1)), static_cast<double>(points(i, 2))};
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Whether the extent of a cloud is more than `times` the distance of its closer pairs.
template <typename Points>
bool may_stand_out(const Points& points, double extent, double times) {
  if (points.size < 4) return false;
  // The two of a pair go through the rows by the powers of 1 / g, g^3 = g + 1, which meet no period of the input and
  // spread pairs evenly over all that there are. Were they always as far from one another, rows of one kind that stand
  // together would never be paired.
  const auto row = [&](std::uint64_t fraction) {
    return static_cast<std::size_t>((fraction >> 32U) * points.size >> 32U);
  };
  std::array<double, kPairs> distances{};
  for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
    const std::size_t i = row((pair + 1) * 0xC13FA9A902A6328FU);
    const std::size_t j = row((pair + 1) * 0x91E10DA5C79E7B1DU);
    distances[pair] = distance(point(points, i), point(points, i == j ? (j + 1) % points.size : j));
  }
  std::nth_element(distances.begin(), distances.begin() + kClosePairs, distances.end());
  return !(extent <= times * distances[kClosePairs]);
}

// Whether a point that several rows have looks like a value written for none: into all three coordinates. A target of a
// board is there by chance, or at the origin, and the other targets remain.
bool is_no_value(const Point& p) { return p[0] == p[1] && p[1] == p[2]; }

// The points, but each "no value" once, however many of these there are, and once each as well up to three other places
// that half of what is left have together: three places prove no pose, so that they are not where most points are. All
// others count as often as they are there, as the targets of a board do that many frames show: of a small board one
// more place is seen about as often.
template <typename Points>
std::vector<Point> counted_points(const Points& points) {
  struct Place {
    Point point;
    std::size_t times;
  };
  std::vector<Point> sorted(points.size);
  for (std::size_t i = 0; i < points.size; ++i) sorted[i] = point(points, i);
  std::sort(sorted.begin(), sorted.end());
  std::vector<Place> places;
  std::size_t rows = 0;
  for (auto first = sorted.begin(); first != sorted.end();) {
    const auto end = std::find_if(first, sorted.end(), [&](const Point& other) { return other != *first; });
    places.push_back({*first, is_no_value(*first) ? 1 : static_cast<std::size_t>(end - first)});
    rows += places.back().times;
    first = end;
  }
  const std::size_t few = std::min(kProvesNoPose + 1, places.size());
  std::partial_sort(
      places.begin(), places.begin() + static_cast<std::ptrdiff_t>(few), places.end(),
      [](const Place& a, const Place& b) { return a.times != b.times ? a.times > b.times : a.point < b.point; });
  std::size_t together = 0;
  for (std::size_t k = 0; k < std::min(kProvesNoPose, few); ++k) {
    together += places[k].times;
    if (2 * together < rows) continue;
    const bool is_board = k + 1 < few && places[k + 1].times > 1 && 2 * places[k + 1].times > places[k].times;
    for (std::size_t place = 0; place <= k && !is_board; ++place) places[place].times = 1;
    break;
  }
  std::vector<Point> counted;
  counted.reserve(rows);
  for (const Place& place : places) counted.insert(counted.end(), place.times, place.point);
  return counted;
}

template <typename Points>
std::vector<double> remoteness_of(const Points& points) {
  const std::vector<Point> counted = counted_points(points);
  Point middle{};
  std::vector<double> values(counted.size());
  for (std::size_t c = 0; c < 3; ++c) {
    std::ranges::transform(counted, values.begin(), [c](const Point& p) { return p[c]; });
    middle[c] = median(values);
  }
  std::ranges::transform(counted, values.begin(), [&](const Point& p) { return distance(p, middle); });
  double radius = median(values);
  std::vector<double> result(points.size, 0.0);
  if (radius == 0.0) {
    std::erase(values, 0.0);
    if (values.empty()) return result;
    radius = median(values);
  }
  // Most of the points being beyond double from one another is for the caller to refuse.
  if (!std::isfinite(radius)) return result;
  for (std::size_t i = 0; i < points.size; ++i) result[i] = distance(point(points, i), middle) / radius;
  return result;
}

}  // namespace

template <typename T>
std::vector<double> remoteness(const PointSpan<T>& source, double source_extent, const PointSpan<T>& target,
                               double target_extent) {
  if (!may_stand_out(source, source_extent, kStandsOut) && !may_stand_out(target, target_extent, kStandsOut)) return {};
  std::vector<double> rows = remoteness_of(source);
  const std::vector<double> of_target = remoteness_of(target);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = std::max(rows[i], of_target[i]);
  if (std::ranges::all_of(rows, [](double value) { return value <= kBulk; })) rows.clear();
  return rows;
}

template <typename T>
std::vector<double> remoteness(const ChosenPoints<T>& points, double extent) {
  // Closer pairs are at a third of the median distance; at a quarter there is room for their scatter.
  if (!may_stand_out(points, extent, kFarOfCloud / 4.0)) return {};
  std::vector<double> rows = remoteness_of(points);
  const auto far =
      static_cast<std::size_t>(std::ranges::count_if(rows, [](double value) { return !(value <= kFarOfCloud); }));
  if (far == 0 || 10 * far > rows.size()) rows.clear();
  return rows;
}

template std::vector<double> remoteness(const ChosenPoints<float>&, double);
template std::vector<double> remoteness(const ChosenPoints<double>&, double);
template std::vector<double> remoteness(const PointSpan<float>&, double, const PointSpan<float>&, double);
template std::vector<double> remoteness(const PointSpan<double>&, double, const PointSpan<double>&, double);

}  // namespace consimd::detail
