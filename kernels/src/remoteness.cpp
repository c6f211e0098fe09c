#include "remoteness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace consimd::detail {
namespace {

// Pairs of points whose distances tell the size of the bulk: with far rows in the minority, two points of four or more
// pairs in ten are none. Copies make the minority the majority of the rows, so the twentieth part of the distances is
// looked at, which is about a quarter of the median distance from the middle.
constexpr std::size_t kPairs = 64;
constexpr std::size_t kClosePairs = kPairs / 20;
constexpr double kStandsOut = 24.0;
constexpr std::size_t kProvesNoPose = 3;  // places

// Fewer places than six have too few pairs to tell anything. Eight must be shown to keep their distances before the
// frame is theirs: of 6 to 100 unrelated places, 4000 times each, so many were in up to three of a thousand.
constexpr std::size_t kFewestThatAgree = 6;
constexpr double kShowsAFrame = 8.0;
// So many lengths tell a share of one row in fifteen. Two of them agree that differ by less than a sixteenth, which
// leaves room for noise, or by less than a sixty-fourth, where chance gives a quarter of the agreements.
constexpr std::size_t kLengths = 8192;
constexpr std::array kAgree{1.0 / 16.0, 1.0 / 64.0};
constexpr double kDeviations = 3.0;
// Points closer than this share of the largest distance are in one place. So many rows are thinned out to places at
// most, each against all others.
constexpr double kOnePlace = 1.0 / 1024.0;
constexpr std::size_t kMostPlaces = 1024;
// A place that is seen again and again is as large as this, in median distances from its middle: seven deviations of
// the difference of two of its points, if these are normally distributed.
constexpr double kRadii = 8.0;

using Point = std::array<double, 3>;

double distance(const Point& p, const Point& from) {
  return std::max({std::abs(p[0] - from[0]), std::abs(p[1] - from[1]), std::abs(p[2] - from[2])});
}

// Half of the Euclidean distance, which no two points overflow.
double half_length(const Point& p, const Point& q) {
  Point half{};
  for (std::size_t c = 0; c < 3; ++c) half[c] = 0.5 * p[c] - 0.5 * q[c];
  const double largest = distance(half, {});
  if (!(largest > 0.0)) return 0.0;
  double squares = 0.0;
  for (const double x : half) squares += x / largest * (x / largest);
  return std::min(largest * std::sqrt(squares), std::numeric_limits<double>::max());
}

template <typename Points>
Point point(const Points& points, std::size_t i) {
  return {static_cast<double>(points(i, 0)), static_cast<double>(points(i, 1)), static_cast<double>(points(i, 2))};
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The two of a pair of so many rows. They go through the rows by the powers of 1 / g, g^3 = g + 1, which meet no period
// of the input and spread pairs evenly over all that there are. Were they always as far from one another, rows of one
// kind that stand together would never be paired.
std::pair<std::size_t, std::size_t> pair_of(std::uint64_t pair, std::size_t rows) {
  const auto row = [rows](std::uint64_t fraction) { return static_cast<std::size_t>((fraction >> 32U) * rows >> 32U); };
  const std::size_t first = row((pair + 1) * 0xC13FA9A902A6328FU);
  const std::size_t second = row((pair + 1) * 0x91E10DA5C79E7B1DU);
  return {first, first == second ? (second + 1) % rows : second};
}

// Whether the extent of a cloud is more than `times` the distance of its closer pairs.
template <typename Points>
bool may_stand_out(const Points& points, double extent, double times) {
  if (points.size < 4) return false;
  std::array<double, kPairs> distances{};
  for (std::uint64_t pair = 0; pair < kPairs; ++pair) {
    const auto [i, j] = pair_of(pair, points.size);
    distances[pair] = distance(point(points, i), point(points, j));
  }
  std::nth_element(distances.begin(), distances.begin() + kClosePairs, distances.end());
  return !(extent <= times * distances[kClosePairs]);
}

// Whether a point that several rows have looks like a value written for none: into all three coordinates. A target of a
// board is there by chance, or at the origin, and the other targets remain.
bool is_no_value(const Point& p) { return p[0] == p[1] && p[1] == p[2]; }

template <typename Points>
std::vector<Point> sorted_points(const Points& points) {
  std::vector<Point> sorted(points.size);
  for (std::size_t i = 0; i < points.size; ++i) sorted[i] = point(points, i);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

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
  const std::vector<Point> sorted = sorted_points(points);
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

// Distances of all points from the middle of `counted`, in median distances of these, `radius`.
struct Remoteness {
  std::vector<double> of_points;
  double radius = 0.0;
};

template <typename Points>
Remoteness remoteness_from(const Points& points, const std::vector<Point>& counted) {
  Point middle{};
  std::vector<double> values(counted.size());
  for (std::size_t c = 0; c < 3; ++c) {
    std::ranges::transform(counted, values.begin(), [c](const Point& p) { return p[c]; });
    middle[c] = median(values);
  }
  std::ranges::transform(counted, values.begin(), [&](const Point& p) { return distance(p, middle); });
  double radius = median(values);
  Remoteness result{std::vector<double>(points.size, 0.0), radius};
  if (radius == 0.0) {
    std::erase(values, 0.0);
    if (values.empty()) return result;
    result.radius = radius = median(values);
  }
  // Most of the points being beyond double from one another is for the caller to refuse.
  if (!std::isfinite(radius)) return result;
  for (std::size_t i = 0; i < points.size; ++i) {
    result.of_points[i] = distance(point(points, i), middle) / radius;
  }
  return result;
}

template <typename Points>
std::vector<Point> distinct_points(const Points& points) {
  std::vector<Point> sorted = sorted_points(points);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  return sorted;
}

std::vector<std::size_t> rows_where(const std::vector<double>& remote, bool in_bulk) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < remote.size(); ++i) {
    if ((remote[i] <= kBulk) == in_bulk) rows.push_back(i);
  }
  return rows;
}

// The rows without those whose point an earlier one has.
template <typename Points>
std::vector<std::size_t> of_different_points(const Points& points, std::vector<std::size_t> rows) {
  std::ranges::stable_sort(rows, {}, [&](std::size_t row) { return point(points, row); });
  const auto same = [&](std::size_t a, std::size_t b) { return point(points, a) == point(points, b); };
  rows.erase(std::unique(rows.begin(), rows.end(), same), rows.end());
  return rows;
}

// Some of the rows, no two of which have both their sources and their targets in one place, so large in either cloud.
template <typename Points>
std::vector<std::size_t> places_of(const Points& source, const Points& target, const std::vector<std::size_t>& rows,
                                   double of_source, double of_target) {
  const std::size_t some = std::min(rows.size(), kMostPlaces);
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < some; ++k) {
    const std::size_t row = rows[k * rows.size() / some];
    const auto is_beside = [&](std::size_t other) {
      return distance(point(source, row), point(source, other)) <= of_source &&
             distance(point(target, row), point(target, other)) <= of_target;
    };
    if (std::ranges::none_of(kept, is_beside)) kept.push_back(row);
  }
  return kept;
}

// How many places keep their distances from one another: at least, if that shows, and at most.
struct Agreement {
  double shown = 0.0;
  double most = 0.0;
};

// The pairs of places, or some of them, tell it: of n places of which m keep their distances a share of (m / n)^2 does.
// Mismatched lengths tell what chance gives. Copies are one place, and so is a value written for none, which is as far
// from all others in both clouds.
template <typename Points>
Agreement agreement(const Points& source, const Points& target, const std::vector<std::size_t>& rows) {
  const std::vector<std::size_t> different = of_different_points(target, of_different_points(source, rows));
  double extent_of_source = 0.0;
  double extent_of_target = 0.0;
  for (const std::size_t row : different) {
    extent_of_source = std::max(extent_of_source, half_length(point(source, row), point(source, different.front())));
    extent_of_target = std::max(extent_of_target, half_length(point(target, row), point(target, different.front())));
  }
  const std::vector<std::size_t> places =
      places_of(source, target, different, kOnePlace * extent_of_source, kOnePlace * extent_of_target);
  if (places.size() < kFewestThatAgree) return {};
  std::vector<double> of_source;
  std::vector<double> of_target;
  const auto add = [&](std::size_t first, std::size_t second) {
    of_source.push_back(half_length(point(source, places[first]), point(source, places[second])));
    of_target.push_back(half_length(point(target, places[first]), point(target, places[second])));
  };
  const std::size_t all = places.size() * (places.size() - 1) / 2;
  if (all <= kLengths) {
    for (std::size_t first = 0; first < places.size(); ++first) {
      for (std::size_t second = 0; second < first; ++second) add(first, second);
    }
  } else {
    for (std::uint64_t pair = 0; pair < kLengths; ++pair) {
      const auto [first, second] = pair_of(pair, places.size());
      add(first, second);
    }
  }
  const std::size_t lengths = of_source.size();
  // Next to the others shorter ones are in one place.
  const double least = kOnePlace * std::max(std::ranges::max(of_source), std::ranges::max(of_target));
  const double number = static_cast<double>(different.size()) /
                        static_cast<double>(std::min(different.size(), kMostPlaces)) *
                        static_cast<double>(places.size());
  Agreement result{0.0, number};
  for (const double tolerance : kAgree) {
    const auto alike = [&](double a, double b) {
      return std::max(a, b) > least && std::abs(a - b) < tolerance * std::max(a, b);
    };
    double agree = 0.0;
    double by_chance = 0.0;
    for (std::size_t k = 0; k < lengths; ++k) {
      agree += alike(of_source[k], of_target[k]) ? 1.0 : 0.0;
      by_chance += alike(of_source[k], of_target[(k + lengths / 2) % lengths]) ? 1.0 : 0.0;
    }
    const double more = agree - by_chance;
    const double error = kDeviations * std::sqrt(agree + by_chance);
    const auto rows_for = [&](double pairs) {
      return number * std::sqrt(std::max(pairs, 0.0) / static_cast<double>(lengths));
    };
    if (more > error) result.shown = std::max(result.shown, rows_for(more));
    result.most = std::min(result.most, rows_for(more + error));
  }
  result.most = std::max(result.most, result.shown);
  return result;
}

// A row is as remote as the more remote one of its points is. `of_source` and `of_target` are the radii of both clouds.
struct RowRemoteness {
  std::vector<double> of_rows;
  double of_source = 0.0;
  double of_target = 0.0;
};

template <typename Points>
RowRemoteness remoteness_of_rows(const Points& source, const std::vector<Point>& of_source, const Points& target,
                                 const std::vector<Point>& of_target) {
  Remoteness rows = remoteness_from(source, of_source);
  const Remoteness others = remoteness_from(target, of_target);
  for (std::size_t i = 0; i < rows.of_points.size(); ++i) {
    rows.of_points[i] = std::max(rows.of_points[i], others.of_points[i]);
  }
  return {std::move(rows.of_points), rows.radius, others.radius};
}

template <typename Points>
std::vector<Point> points_of(const Points& points, const std::vector<std::size_t>& rows) {
  std::vector<Point> result(rows.size());
  std::ranges::transform(rows, result.begin(), [&](std::size_t row) { return point(points, row); });
  return result;
}

}  // namespace

template <typename T>
std::vector<double> remoteness(const PointSpan<T>& source, double source_extent, const PointSpan<T>& target,
                               double target_extent) {
  if (!may_stand_out(source, source_extent, kStandsOut) && !may_stand_out(target, target_extent, kStandsOut)) return {};
  const RowRemoteness bulk = remoteness_of_rows(source, counted_points(source), target, counted_points(target));
  std::vector<double> rows = bulk.of_rows;
  // Where most points are need not be where the rows tell of a motion: a few targets seen in most rows, a little
  // elsewhere in each, a coordinate that is lost in most, far rows that are copied. The frame is another one's where
  // more rows are shown to keep their distances there than may keep them here.
  double most = agreement(source, target, rows_where(rows, true)).most;
  const auto offer = [&](RowRemoteness other, std::vector<std::size_t> told_by) {
    if (!std::isfinite(other.of_source) || !std::isfinite(other.of_target)) return;
    std::erase_if(told_by, [&](std::size_t row) { return other.of_rows[row] > kBulk; });
    const Agreement of_other = agreement(source, target, told_by);
    if (of_other.shown < kShowsAFrame || of_other.shown <= most) return;
    most = of_other.most;
    rows = std::move(other.of_rows);
  };
  std::vector<std::size_t> all(rows.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  offer(remoteness_of_rows(source, distinct_points(source), target, distinct_points(target)), std::move(all));
  const std::vector<std::size_t> elsewhere = rows_where(bulk.of_rows, false);
  const auto offer_elsewhere = [&](const std::vector<std::size_t>& told_by) {
    if (told_by.size() < kFewestThatAgree) return;
    offer(remoteness_of_rows(source, points_of(source, told_by), target, points_of(target, told_by)), told_by);
  };
  offer_elsewhere(elsewhere);
  offer_elsewhere(places_of(source, target, elsewhere, kRadii * bulk.of_source, kRadii * bulk.of_target));
  if (std::ranges::all_of(rows, [](double value) { return value <= kBulk; })) rows.clear();
  return rows;
}

template <typename T>
std::vector<double> remoteness(const ChosenPoints<T>& points, double extent) {
  // Closer pairs are at a quarter of the median distance.
  if (!may_stand_out(points, extent, kFarOfCloud / 4.0)) return {};
  std::vector<double> rows = remoteness_from(points, counted_points(points)).of_points;
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
