#include <consimd/features/point_subset.hpp>

#include <gtest/gtest.h>

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

#include <consimd/features/cloud_matching.hpp>
#include "scene.hpp"

namespace consimd::test {
namespace {

TEST(RandomSubset, IsAscendingAndFair) {
  std::vector<int> chosen(50, 0);
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    const std::vector<std::uint32_t> rows = features::random_subset(50, 10, seed);
    ASSERT_EQ(rows.size(), 10u);
    EXPECT_TRUE(std::adjacent_find(rows.begin(), rows.end(), std::greater_equal<>()) == rows.end());
    for (const std::uint32_t row : rows) ++chosen.at(row);
  }
  // 400 expected, standard deviation 18
  for (const int count : chosen) EXPECT_NEAR(count, 400, 90);
  EXPECT_EQ(features::random_subset(5, 10, 1).size(), 5u);
  EXPECT_TRUE(features::random_subset(0, 10, 1).empty());
  EXPECT_EQ(features::random_subset(1000, 10, 3), features::random_subset(1000, 10, 3));
}

/// By its definition: of each point the distance to its nearest chosen one, all of them looked at.
std::vector<std::uint32_t> farthest_of(const Cloud& cloud, std::size_t count, std::uint32_t first) {
  const CloudView view = cloud.view();
  std::vector<float> nearest(cloud.size(), std::numeric_limits<float>::infinity());
  std::vector<std::uint32_t> rows{first};
  for (;;) {
    const std::uint32_t last = rows.back();
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      float squared = 0.0f;
      for (std::size_t c = 0; c < 3; ++c) {
        const float along = view.points(c)[i] - view.points(c)[last];
        squared += along * along;
      }
      nearest[i] = std::min(nearest[i], squared);
    }
    nearest[last] = -1.0f;
    if (rows.size() == count) return rows;
    rows.push_back(static_cast<std::uint32_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin()));
  }
}

TEST(FarthestSubset, IsThatOfItsDefinition) {
  Points on_a_lattice, copies = room(90, 3);
  for (int i = 0; i < 1000; ++i) {
    const int x = i % 10, y = i / 10 % 10, z = i / 100;
    on_a_lattice.push_back({0.5 * x, 0.5 * y, 0.5 * z});  // many are equally far
  }
  copies.insert(copies.end(), copies.begin(), copies.begin() + 60);
  const Points line = [] {
    Points points;
    for (int i = 0; i < 300; ++i) points.push_back({5e6 + 0.1 * (i * 37 % 300), 0.0, -2.0});
    return points;
  }();
  for (const Points& points : {room(3000, 1), on_a_lattice, copies, line, Points(70, {1, 2, 3}), Points{{1, 2, 3}}}) {
    const Cloud cloud = cloud_of(points);
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const std::size_t count = std::min<std::size_t>(cloud.size(), 400);
      const std::vector<std::uint32_t> rows = features::farthest_subset(cloud, count, seed);
      ASSERT_EQ(rows.size(), count);
      EXPECT_EQ(rows.front(), features::random_subset(cloud.size(), 1, seed).front());
      EXPECT_EQ(rows, farthest_of(cloud, count, rows.front())) << points.size() << " points";
    }
  }
}

TEST(FarthestSubset, ComesNearerAndNearer) {
  const Cloud cloud = cloud_of(room(5000, 4));
  const std::vector<std::uint32_t> rows = features::farthest_subset(cloud, 800, 7);
  const auto distance = [&](std::size_t a, std::size_t b) {
    const auto p = cloud.point(rows[a]), q = cloud.point(rows[b]);
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
  };
  double last = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < rows.size(); ++k) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t before = 0; before < k; ++before) nearest = std::min(nearest, distance(k, before));
    EXPECT_LE(nearest, last + 1e-5) << k;
    last = nearest;
  }
  // Drawn at random some lie much closer to each other.
  EXPECT_GT(last, 0.2);
}

TEST(FarthestSubset, OfAllOrNonePoints) {
  const Cloud cloud = cloud_of(room(200, 5));
  std::vector<std::uint32_t> rows = features::farthest_subset(cloud, 1000, 1);
  std::sort(rows.begin(), rows.end());
  std::vector<std::uint32_t> all(200);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(rows, all);
  EXPECT_TRUE(features::farthest_subset(cloud, 0, 1).empty());
  EXPECT_TRUE(features::farthest_subset(Cloud(), 10, 1).empty());
  const Cloud copies = cloud_of(Points(100, {1, 2, 3}));
  rows = features::farthest_subset(copies, 99, 1);
  std::sort(rows.begin(), rows.end());
  EXPECT_TRUE(std::adjacent_find(rows.begin(), rows.end()) == rows.end());
}

TEST(FarthestSubset, IsWhatCloudsAreMatchedBy) {
  const Cloud source = cloud_of(room(20000, 1)), target = cloud_of(room(20000, 2));
  features::CloudMatchingOptions options{.voxel = 0.2, .keypoints = 500, .farthest = true};
  std::vector<std::array<double, 3>> expected;
  for (const Isa isa : supported_isas()) {
    set_active_isa(isa);
    for (const int threads : {1, 2, 4}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 4);
      tbb::task_arena arena(threads);
      const features::CloudMatches found =
          arena.execute([&] { return features::match_clouds(source, target, options); });
      EXPECT_EQ(found.source.descriptors, 500u);
      EXPECT_EQ(found.stages[2].name, "farthest");
      EXPECT_EQ(found.stages[2].output, 1000u);
      if (expected.empty()) expected = found.source_points;
      EXPECT_EQ(found.source_points, expected) << to_string(isa) << " on " << threads;
    }
  }
  set_active_isa(supported_isas().back());
  options.seed = 2;
  EXPECT_NE(features::match_clouds(source, target, options).source_points, expected);
  options.keypoints = std::nullopt;  // all: nothing to choose
  const features::CloudMatches all = features::match_clouds(source, target, options);
  EXPECT_EQ(all.source.descriptors, all.source.voxels);
}

}  // namespace
}  // namespace consimd::test
