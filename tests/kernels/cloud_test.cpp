#include <consimd/kernels/cloud.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace consimd::test {
namespace {

using Rows = std::vector<std::array<double, 3>>;

Cloud cloud_of(const Rows& rows, std::optional<double> missing = std::nullopt) {
  return Cloud(PointSpan<double>::interleaved(rows.empty() ? nullptr : rows.front().data(), rows.size()), missing);
}

/// A wavy surface of 10 m.
Rows surface(std::size_t count) {
  Rows rows;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = 10.0 * static_cast<double>(i * 377 % count) / static_cast<double>(count);
    const double y = 1.0 + 10.0 * static_cast<double>(i) / static_cast<double>(count);
    rows.push_back({x, y, std::sin(x)});
  }
  return rows;
}

TEST(Cloud, LeavesOutRowsWithoutAPlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::array<double, 15> rows{
      1, 2, 3, nan, 0, 0, 0, 0, 0, 5, 2, 0, 0, 0, std::numeric_limits<double>::infinity()};
  const Cloud cloud(PointSpan<double>::interleaved(rows.data(), 5), 0.0);
  EXPECT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.left_out(), 3u);
  EXPECT_EQ(cloud.input_row(1), 3u);
  EXPECT_EQ(cloud.point(1), (std::array<double, 3>{5, 2, 0}));
  EXPECT_EQ(Cloud(PointSpan<double>::interleaved(rows.data(), 5)).size(), 3u);
  EXPECT_TRUE(Cloud(PointSpan<double>::interleaved(rows.data() + 3, 1)).empty());
}

TEST(Cloud, KeepsMapCoordinates) {
  std::mt19937 random(2);
  std::vector<double> rows(3000);
  for (double& x : rows) x = 5e6 + 50.0 * std::ldexp(static_cast<double>(static_cast<std::int32_t>(random())), -31);
  const Cloud cloud(PointSpan<double>::planar(rows.data(), 1000));
  for (std::size_t i = 0; i < 1000; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(cloud.point(i)[c], rows[1000 * c + i], 1e-5);
  }
  const Cloud chosen = cloud.subset(std::vector<std::uint32_t>{7, 7, 3});
  EXPECT_EQ(chosen.point(2), cloud.point(3));
  EXPECT_THROW(cloud.subset(std::vector<std::uint32_t>{1000}), std::out_of_range);
}

TEST(Cloud, LeavesOutStrayPoints) {
  const Rows rows = surface(1000);
  const Cloud expected = cloud_of(rows);
  for (const double far : {1e5, -1e7, 1e30, 1e308}) {
    Rows with = rows;
    with.insert(with.begin() + 3, {far, 0.0, far});
    with.insert(with.begin() + 500, 20, {far, -far, 1.0});  // a cluster
    with.push_back({1.0, 1.0, -far});
    for (std::size_t i = 0; i < 50; ++i) with.push_back({0.0, 0.0, 0.0});
    const Cloud cloud = cloud_of(with, 0.0);
    ASSERT_EQ(cloud.size(), rows.size()) << far;
    EXPECT_EQ(cloud.left_out(), 72u);
    EXPECT_EQ(cloud.origin(), expected.origin());
    EXPECT_EQ(cloud.scale(), expected.scale());
    EXPECT_EQ(cloud.input_row(3), 4u);
    EXPECT_EQ(cloud.input_row(999), 1020u);
    for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(cloud.point(i), expected.point(i));
  }
}

TEST(Cloud, KeepsWhatIsMerelyDistant) {
  // The ground under a scanner, and a facade a kilometre away; a tenth of the points in another place; few points.
  Rows distant = surface(1000), elsewhere = surface(1000);
  distant.push_back({2000.0, 0.0, 30.0});
  elsewhere.insert(elsewhere.end(), 150, {1e7, 0.0, 0.0});
  for (const Rows& rows : {distant, elsewhere, Rows{{0, 0, 0}, {1e7, 0, 0}}, Rows{{0, 0, 0}, {1, 0, 0}, {1e9, 0, 0}}}) {
    EXPECT_EQ(cloud_of(rows).size(), rows.size());
  }
  // Most points in one place, as of a sensor whose marker was not named: the others are what the cloud is.
  Rows copies(3000, {0.0, 0.0, 0.0});
  const Rows rows = surface(1000);
  copies.insert(copies.end(), rows.begin(), rows.end());
  EXPECT_EQ(cloud_of(copies).size(), copies.size());
}

}  // namespace
}  // namespace consimd::test
