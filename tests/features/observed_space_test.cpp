// The maps that poses are held against: surfaces in cubes, and what a scan saw through.
#include "verification/observed_space.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <consimd/features/cell_grid.hpp>
#include <consimd/kernels/cloud.hpp>

namespace consimd::features::detail {
namespace {

constexpr double kVoxel = 0.5;

class SurfaceMaps : public ::testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3 direction() {
    const double z = uniform(-1.0, 1.0), turn = uniform(0.0, 6.283);
    const double across = std::sqrt(1.0 - z * z);
    return {across * std::cos(turn), across * std::sin(turn), z};
  }
  Vector3 place(double reach) { return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)}; }

  /// Points all over a box, which reach more cubes than those of surfaces: the table has to grow. Of every other one
  /// the front is known.
  std::vector<SurfacePoint> scattered(std::size_t count) {
    std::vector<SurfacePoint> points(count);
    for (std::size_t i = 0; i < count; ++i) points[i] = {place(10.0), direction(), i % 2 == 0};
    return points;
  }

  std::mt19937 random_{7};
};

TEST_F(SurfaceMaps, CubesKnowThePointNearestToTheirCentre) {
  const SurfaceMap map(scattered(3000), kVoxel);
  ASSERT_EQ(map.surfaces().size(), 3000U);
  Vector3 low{1e9, 1e9, 1e9};
  for (const SurfacePoint& surface : map.surfaces()) {
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], surface.point[c] - 2.0 * kVoxel);
  }
  std::array<std::size_t, 3> seen{};
  for (int k = 0; k < 2000; ++k) {
    const SurfacePoint asked{place(11.5), direction()};
    double nearest = 1.5 * 1.5 * kVoxel * kVoxel;
    const SurfacePoint* expected = nullptr;
    for (const SurfacePoint& surface : map.surfaces()) {
      double squared = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double centre = low[c] + (std::floor((asked.point[c] - low[c]) / kVoxel) + 0.5) * kVoxel;
        squared += (surface.point[c] - centre) * (surface.point[c] - centre);
      }
      if (squared >= nearest) continue;
      nearest = squared;
      expected = &surface;
    }
    Agreement agreement = Agreement::empty;
    if (expected != nullptr) {
      double offset = 0.0;
      for (std::size_t c = 0; c < 3; ++c) offset += (asked.point[c] - expected->point[c]) * expected->normal[c];
      const bool passes = std::abs(offset) <= kVoxel && of_like_orientation(asked, *expected);
      agreement = passes ? Agreement::surface : Agreement::other;
      EXPECT_EQ(map.surface_at(asked), passes ? expected : nullptr);
    }
    EXPECT_EQ(map.agreement(asked), agreement);
    ++seen[static_cast<std::size_t>(agreement)];
  }
  for (const std::size_t count : seen) EXPECT_GT(count, 100U);
}

// A surface that is seen from one side is none where its back would be seen, unless it was seen along itself, or not
// from there: as on a cone of the ground under a scanner, out to where it is seen at four degrees, and what is under
// it.
TEST_F(SurfaceMaps, FrontsAreNoBacks) {
  const Vector3 above{0.0, 0.0, 2.0};
  std::vector<Vector3> points;
  for (int k = 0; k < 20000; ++k) {
    const double turn = uniform(0.0, 6.283), range = uniform(0.0, 26.0);
    points.push_back({range * std::cos(turn), range * std::sin(turn), 0.0});
  }
  points.push_back({1.0, 0.0, -8.0});
  CellGrid grid(Cloud(PointSpan<double>::interleaved(points.front().data(), points.size())), 2.0);
  std::array<std::vector<float>, 3> normals;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    normals[0].push_back(0.0F);
    normals[1].push_back(0.0F);
    normals[2].push_back(i % 2 == 0 ? 1.0F : -1.0F);
  }
  grid.set_normals({normals[0].data(), normals[1].data(), normals[2].data()});
  const std::vector<SurfacePoint> seen = surface_points(grid, FreeSpace(grid.cloud(), above, 4.0));
  const std::vector<SurfacePoint> unseen = surface_points(grid, FreeSpace());
  ASSERT_EQ(seen.size(), points.size());
  std::size_t fronts = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double range = std::hypot(seen[i].point[0], seen[i].point[1]);
    EXPECT_EQ(seen[i].normal[2], 1.0);
    const bool is_told = seen[i].point[2] > -1.0 && range < 22.0;
    EXPECT_TRUE(is_told || range < 23.0 || !seen[i].has_front) << range;
    EXPECT_TRUE(seen[i].point[2] > -1.0 || !seen[i].has_front);
    fronts += is_told && seen[i].has_front ? 1U : 0U;
    EXPECT_EQ(unseen[i].normal[2], i % 2 == 0 ? 1.0 : -1.0);
    EXPECT_FALSE(unseen[i].has_front);
  }
  EXPECT_GT(fronts, points.size() / 2);
  const SurfacePoint front{above, {0.0, 0.6, 0.8}, true}, back{above, {0.0, -0.6, -0.8}, true};
  const SurfacePoint either{above, {0.0, -0.6, -0.8}, false};
  EXPECT_TRUE(of_like_orientation(front, front));
  EXPECT_FALSE(of_like_orientation(front, back));
  EXPECT_TRUE(of_like_orientation(front, either));
  EXPECT_TRUE(of_like_orientation(either, front));
}

TEST_F(SurfaceMaps, PlacesTogetherAreWhatTheyAreAlone) {
  const SurfaceMap map(scattered(500), kVoxel);
  for (const std::size_t count : {0U, 1U, 63U, 64U, 65U, 320U}) {
    std::vector<SurfacePoint> places(count);
    for (SurfacePoint& asked : places) asked = {place(12.0), direction(), random_() % 2 == 0};
    std::vector<Agreement> found(count, Agreement::other);
    map.agreements(places, found);
    for (std::size_t k = 0; k < count; ++k) EXPECT_EQ(found[k], map.agreement(places[k]));
  }
}

TEST_F(SurfaceMaps, WhatLiesBeforeTheSurfacesIsSeenThrough) {
  const Vector3 viewpoint{100.0, -20.0, 3.0};
  const auto at_range = [&](double range) {
    const Vector3 d = direction();
    return Vector3{viewpoint[0] + range * d[0], viewpoint[1] + range * d[1], viewpoint[2] + range * d[2]};
  };
  std::vector<Vector3> sphere(200'000);
  for (Vector3& point : sphere) point = at_range(10.0);
  const FreeSpace space(Cloud(PointSpan<double>::interleaved(sphere.front().data(), sphere.size())), viewpoint, 1.0);
  std::vector<SurfacePoint> places;
  std::vector<std::uint32_t> counts{0};  // of the first so many places, one by one
  for (int k = 0; k < 200; ++k) {
    const bool is_before = k % 2 == 0;
    places.push_back({at_range(is_before ? uniform(0.5, 8.9) : uniform(9.1, 30.0)), {}});
    const std::uint32_t seen = space.count_seen_through(std::span(places).last(1));
    EXPECT_LE(seen, is_before ? 1U : 0U);
    counts.push_back(counts.back() + seen);
  }
  // Two points a cell leave one in seven without any, of which nothing is known.
  EXPECT_GT(counts.back(), 70U);
  for (const std::size_t count : {0U, 1U, 63U, 64U, 65U, 200U}) {
    EXPECT_EQ(space.count_seen_through(std::span(places).first(count)), counts[count]);
  }
  EXPECT_EQ(FreeSpace().count_seen_through(places), 0U);
  // From so far away all are at one range.
  const FreeSpace far(Cloud(PointSpan<double>::interleaved(sphere.front().data(), sphere.size())), {1e30, 0.0, 0.0},
                      1.0);
  EXPECT_FALSE(far.viewpoint());
  EXPECT_FALSE(far.sees(places.front().point));
  EXPECT_EQ(far.count_seen_through(places), 0U);
}

}  // namespace
}  // namespace consimd::features::detail
