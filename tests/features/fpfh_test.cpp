#include <consimd/features/fpfh.hpp>
#include <consimd/features/matching.hpp>
#include <consimd/features/normals.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "scene.hpp"

namespace consimd::test {
namespace {

using features::CellGrid;
using Histogram = Eigen::Array<double, 33, 1>;

Eigen::Vector3d point(const CellGrid& grid, std::size_t i) {
  const auto p = grid.cloud().point(i);
  return {p[0], p[1], p[2]};
}

Eigen::Vector3d normal(const CellGrid& grid, std::size_t i) {
  const CloudView view = grid.cloud().view();
  return Eigen::Vector3f(view.normals(0)[i], view.normals(1)[i], view.normals(2)[i]).cast<double>();
}

std::vector<std::size_t> near(const CellGrid& grid, std::size_t i, double radius) {
  std::vector<std::size_t> rows;
  for (std::size_t j = 0; j < grid.size(); ++j) {
    if (j != i && (point(grid, j) - point(grid, i)).norm() <= radius) rows.push_back(j);
  }
  return rows;
}

/// As the paper and PCL's documentation have it, in double, with an arc tangent.
Histogram spfh(const CellGrid& grid, std::size_t i, double radius) {
  Histogram histogram = Histogram::Zero();
  const std::vector<std::size_t> rows = near(grid, i, radius);
  for (const std::size_t j : rows) {
    Eigen::Vector3d d = point(grid, j) - point(grid, i);
    Eigen::Vector3d u = normal(grid, i), n = normal(grid, j);
    if (std::abs(u.dot(d)) < std::abs(n.dot(d))) {
      std::swap(u, n);
      d = -d;
    }
    const Eigen::Vector3d v = d.cross(u).normalized();
    const Eigen::Vector3d w = u.cross(v);
    const double features[3] = {std::atan2(w.dot(n), u.dot(n)) / std::numbers::pi, v.dot(n), u.dot(d.normalized())};
    for (int f = 0; f < 3; ++f) {
      histogram[11 * f + std::clamp(static_cast<int>(std::floor(11.0 * (features[f] + 1.0) / 2.0)), 0, 10)] +=
          100.0 / static_cast<double>(rows.size());
    }
  }
  return histogram;
}

Histogram textbook_fpfh(const CellGrid& grid, std::size_t i, double radius) {
  Histogram sum = Histogram::Zero();
  for (const std::size_t j : near(grid, i, radius)) {
    sum += spfh(grid, j, radius) / (point(grid, j) - point(grid, i)).squaredNorm();
  }
  for (int f = 0; f < 3; ++f) sum.segment<11>(11 * f) *= 100.0 / sum.segment<11>(11 * f).sum();
  return sum;
}

CellGrid described_room(std::size_t size) {
  CellGrid grid(cloud_of(room(size, 6)), 1.0);
  features::estimate_normals(grid, {0.7, std::array<double, 3>{0.0, 0.0, 1.5}});
  return grid;
}

TEST(Fpfh, IsTheTextbooks) {
  const CellGrid grid = described_room(1500);
  const std::vector<std::uint32_t> rows{5, 77, 500, 777, 1234, 1499};
  const features::Descriptors descriptors = features::fpfh(grid, rows, 0.9);
  ASSERT_EQ(descriptors.rows, rows);
  ASSERT_EQ(descriptors.length, 33u);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Histogram expected = textbook_fpfh(grid, rows[k], 0.9);
    const Histogram found =
        Eigen::Map<const Eigen::Array<float, 33, 1>>(descriptors.values.data() + 33 * k).cast<double>();
    // Of some thousand pairs one or two may be so near the border of two bins that rounding counts them in the other.
    EXPECT_LE(((found - expected).abs() > 0.01).count(), 4) << rows[k];
    EXPECT_LT((found - expected).abs().maxCoeff(), 1.0) << rows[k];
  }
}

TEST(Fpfh, OfFewPointsAreThoseOfAll) {
  const CellGrid grid = described_room(3000);
  std::vector<std::uint32_t> all(grid.size());
  std::iota(all.begin(), all.end(), 0u);
  const features::Descriptors of_all = features::fpfh(grid, all, 1.0);
  const std::vector<std::uint32_t> few{3, 44, 2222};
  const features::Descriptors of_few = features::fpfh(grid, few, 1.0);
  ASSERT_EQ(of_few.rows, few);
  for (std::size_t k = 0; k < few.size(); ++k) {
    const auto at =
        static_cast<std::size_t>(std::find(of_all.rows.begin(), of_all.rows.end(), few[k]) - of_all.rows.begin());
    ASSERT_LT(at, of_all.size());
    EXPECT_TRUE(std::equal(of_few.values.begin() + static_cast<std::ptrdiff_t>(33 * k),
                           of_few.values.begin() + static_cast<std::ptrdiff_t>(33 * (k + 1)),
                           of_all.values.begin() + static_cast<std::ptrdiff_t>(33 * at)));
  }
}

TEST(Fpfh, OfALonelyPointIsMissing) {
  Points points = room(500, 8);
  points.push_back({100.0, 0.0, 0.0});
  CellGrid grid(cloud_of(points), 1.0);
  std::vector<std::uint32_t> rows(grid.size());
  std::iota(rows.begin(), rows.end(), 0u);
  EXPECT_THROW(static_cast<void>(features::fpfh(grid, rows, 1.0)), std::invalid_argument);  // without normals
  features::estimate_normals(grid, {0.7, std::nullopt});
  const features::Descriptors descriptors = features::fpfh(grid, rows, 1.0);
  EXPECT_LT(descriptors.size(), grid.size());
  for (const std::uint32_t row : descriptors.rows) EXPECT_LT(grid.cloud().point(row)[0], 50.0);
  for (const float value : descriptors.values) EXPECT_TRUE(std::isfinite(value));
  EXPECT_THROW(static_cast<void>(features::fpfh(grid, rows, 1.1)), std::invalid_argument);
}

/// Matches by sorting all distances, in double.
std::vector<std::pair<std::uint32_t, std::uint32_t>> expected_matches(const std::vector<float>& a,
                                                                      const std::vector<float>& b, std::size_t length,
                                                                      const features::MatchOptions& options) {
  const std::size_t n = a.size() / length, m = b.size() / length;
  std::vector<double> distances(n * m);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < m; ++j) {
      double sum = 0.0;
      for (std::size_t c = 0; c < length; ++c) {
        const double difference = double{a[i * length + c]} - double{b[j * length + c]};
        sum += difference * difference;
      }
      distances[i * m + j] = std::sqrt(sum);
    }
  }
  const auto distance = [&](std::size_t i, std::size_t j) { return distances[i * m + j]; };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
  for (std::uint32_t i = 0; i < n; ++i) {
    std::vector<std::uint32_t> order(m);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](auto j, auto k) { return distance(i, j) < distance(i, k); });
    if (m > 1 && options.ratio < 1.0 && !(distance(i, order[0]) < options.ratio * distance(i, order[1]))) continue;
    for (std::size_t rank = 0; rank < std::min(options.best, m); ++rank) {
      const std::uint32_t j = order[rank];
      std::size_t nearer = 0;
      for (std::size_t other = 0; other < n; ++other) nearer += distance(other, j) < distance(i, j) ? 1u : 0u;
      if (!options.mutual || nearer < options.best) matches.emplace_back(i, j);
    }
  }
  return matches;
}

TEST(Match, IsByEuclideanDistance) {
  std::mt19937 random(3);
  for (const std::size_t length : {3u, 33u, 256u}) {
    for (const auto& [n, m] : {std::pair<std::size_t, std::size_t>{0, 9}, {9, 0}, {1, 1}, {40, 70}, {300, 130}}) {
      std::vector<float> a(n * length), b(m * length);
      for (float& x : a) x = static_cast<float>(uniform(random));
      for (float& x : b) x = static_cast<float>(uniform(random));
      for (const features::MatchOptions& options :
           {features::MatchOptions{}, features::MatchOptions{1, true}, features::MatchOptions{1, false},
            features::MatchOptions{8, true}, features::MatchOptions{2, false, 0.97}}) {
        const std::vector<features::Match> found = features::match(a, b, length, options);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
        pairs.reserve(found.size());
        for (const features::Match& match : found) pairs.emplace_back(match.source, match.target);
        const auto expected = expected_matches(a, b, length, options);
        // Distances that differ by less than a unit in fixed point may change places.
        std::vector<std::pair<std::uint32_t, std::uint32_t>> common;
        std::sort(pairs.begin(), pairs.end());
        auto sorted = expected;
        std::sort(sorted.begin(), sorted.end());
        std::set_intersection(pairs.begin(), pairs.end(), sorted.begin(), sorted.end(), std::back_inserter(common));
        EXPECT_LE(pairs.size() - common.size(), 1 + pairs.size() / 200);
        EXPECT_LE(sorted.size() - common.size(), 1 + sorted.size() / 200);
      }
    }
  }
}

TEST(Match, NamesWhatIsWrong) {
  const std::vector<float> values(66, 1.0f), uneven(67, 1.0f);
  EXPECT_THROW(static_cast<void>(features::match(values, values, 33, {0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::match(values, values, 33, {9})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::match(values, values, 33, {1, true, 0.0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::match(values, values, 33, {1, true, 1.0, 3.0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::match(values, uneven, 33)), std::invalid_argument);
  std::vector<float> broken = values;
  broken[40] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(static_cast<void>(features::match(values, broken, 33)), std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
