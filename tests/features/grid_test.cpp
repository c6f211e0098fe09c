#include <consimd/features/cell_grid.hpp>
#include <consimd/features/normals.hpp>
#include <consimd/features/voxel_grid.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "scene.hpp"

namespace consimd::test {
namespace {

using features::CellGrid;

TEST(VoxelGrid, HasTheMeanOfEachCube) {
  const Points points = room(20000, 3);
  const Cloud cloud = cloud_of(points);
  const double voxel = 0.31;
  std::array<double, 3> low{1e9, 1e9, 1e9};
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], cloud.point(i)[c]);
  }
  std::map<std::array<long, 3>, std::pair<Eigen::Vector3d, int>> cubes;  // by z, y, x
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto p = cloud.point(i);
    std::array<long, 3> cube{};
    for (std::size_t c = 0; c < 3; ++c) cube[2 - c] = static_cast<long>(std::floor((p[c] - low[c]) / voxel));
    auto& [sum, count] = cubes.try_emplace(cube, Eigen::Vector3d::Zero(), 0).first->second;
    sum += Eigen::Map<const Eigen::Vector3d>(p.data());
    ++count;
  }
  const Cloud voxels = features::voxel_grid(cloud, voxel);
  ASSERT_EQ(voxels.size(), cubes.size());
  EXPECT_EQ(features::occupied_voxels(cloud, voxel), cubes.size());
  std::size_t row = 0;
  for (const auto& [cube, content] : cubes) {
    const auto p = voxels.point(row++);
    EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(p.data()) - content.first / content.second).norm(), 1e-5);
  }
}

TEST(VoxelGrid, OfManyPointsIsThatOfTheirBlocks) {
  // more points than one table takes; a quarter of a million in two places
  Points points = room(250000, 5);
  const Cloud voxels = features::voxel_grid(cloud_of(points), 0.5);
  std::reverse(points.begin(), points.end());
  const Cloud reversed = features::voxel_grid(cloud_of(points), 0.5);
  ASSERT_EQ(voxels.size(), reversed.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(voxels.point(i)[c], reversed.point(i)[c], 1e-5);
  }
}

TEST(VoxelGrid, NamesABadVoxel) {
  const Cloud cloud = cloud_of(room(100, 1));
  for (const double voxel : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity(), 1e-9}) {
    EXPECT_THROW(static_cast<void>(features::voxel_grid(cloud, voxel)), std::invalid_argument) << voxel;
  }
  EXPECT_TRUE(features::voxel_grid(Cloud(), 1.0).empty());
}

TEST(CellGrid, FindsTheNearestOfAnyPlace) {
  std::mt19937 random(4);
  for (const std::size_t size : {0u, 1u, 2u, 50u, 3000u}) {
    const CellGrid grid(cloud_of(room(size, 7)), 0.6);
    // inside, beside and far outside of the cloud, in no order
    Points queries = room(150, 8);
    for (int k = 0; k < 200; ++k)
      queries.push_back({7.0 * uniform(random), 7.0 * uniform(random), 4.0 * uniform(random)});
    queries.push_back({1e9, 0.0, 0.0});
    queries.push_back({0.0, -1e300, std::nan("")});
    for (const std::size_t most : {1u, 2u, 7u, 32u}) {
      const double radius = most == 2 ? 0.6 : 0.45;
      const features::NearestLists lists = features::nearest_neighbours(grid, queries, most, radius);
      ASSERT_EQ(lists.rows.size(), most * queries.size());
      for (std::size_t k = 0; k < queries.size(); ++k) {
        std::vector<double> expected;
        for (std::size_t j = 0; j < grid.size(); ++j) {
          const auto q = grid.cloud().point(j);
          const double distance = std::hypot(q[0] - queries[k][0], q[1] - queries[k][1], q[2] - queries[k][2]);
          if (distance <= radius) expected.push_back(distance);
        }
        std::sort(expected.begin(), expected.end());
        expected.resize(most, std::numeric_limits<double>::infinity());
        for (std::size_t rank = 0; rank < most; ++rank) {
          const std::uint32_t row = lists.rows[k * most + rank];
          const double distance = lists.distances[k * most + rank];
          ASSERT_EQ(row == features::NearestLists::kNone, std::isinf(expected[rank])) << k << " " << rank;
          if (std::isinf(expected[rank])) {
            EXPECT_TRUE(std::isinf(distance));
            continue;
          }
          EXPECT_NEAR(distance, expected[rank], 1e-5);
          const auto q = grid.cloud().point(row);
          EXPECT_NEAR(distance, std::hypot(q[0] - queries[k][0], q[1] - queries[k][1], q[2] - queries[k][2]), 1e-5);
        }
      }
    }
  }
  const CellGrid grid(cloud_of(room(50, 7)), 0.6);
  EXPECT_THROW(static_cast<void>(features::nearest_neighbours(grid, {}, 1, 0.7)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::nearest_neighbours(grid, {}, 0, 0.5)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::nearest_neighbours(grid, {}, 65, 0.5)), std::invalid_argument);
}

TEST(CellGrid, FindsAllNeighbours) {
  for (const std::size_t size : {0u, 1u, 2u, 50u, 3000u}) {
    const Cloud cloud = cloud_of(room(size, 7));
    const CellGrid grid(cloud, 0.6);
    std::vector<std::uint32_t> rows;
    for (std::uint32_t row = 0; row < grid.size(); row += 1 + row % 5) rows.push_back(row);
    const double radius = 0.55;
    const features::NeighbourLists lists = features::radius_neighbours(grid, rows, radius);
    ASSERT_EQ(lists.starts.size(), rows.size() + 1);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto p = grid.cloud().point(rows[k]);
      std::vector<std::uint32_t> expected;
      for (std::uint32_t j = 0; j < grid.size(); ++j) {
        const auto q = grid.cloud().point(j);
        if (std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) <= radius) expected.push_back(j);
      }
      const std::vector<std::uint32_t> found(lists.rows.begin() + static_cast<std::ptrdiff_t>(lists.starts[k]),
                                             lists.rows.begin() + static_cast<std::ptrdiff_t>(lists.starts[k + 1]));
      ASSERT_EQ(found, expected);
      for (std::size_t e = lists.starts[k]; e < lists.starts[k + 1]; ++e) {
        const auto q = grid.cloud().point(lists.rows[e]);
        EXPECT_NEAR(lists.distances[e], std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]), 1e-5);
      }
    }
  }
}

TEST(CellGrid, KeepsTrackOfItsPoints) {
  const Cloud cloud = cloud_of(room(500, 9));
  const CellGrid grid(cloud, 1.0);
  for (std::size_t row = 0; row < grid.size(); ++row) {
    EXPECT_EQ(grid.cloud().point(row), cloud.point(grid.original(row)));
  }
}

TEST(CellGrid, NamesWhatIsWrong) {
  const CellGrid grid(cloud_of(room(50, 1)), 1.0);
  const std::vector<std::uint32_t> falling{2, 1}, beyond{50}, one{0};
  EXPECT_THROW(static_cast<void>(features::radius_neighbours(grid, falling, 0.5)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::radius_neighbours(grid, beyond, 0.5)), std::out_of_range);
  EXPECT_THROW(static_cast<void>(features::radius_neighbours(grid, one, 1.5)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(features::resolution(CellGrid(Cloud(), 1.0))), std::invalid_argument);
}

TEST(Resolution, IsTheSpacingOfALattice) {
  Points lattice;
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) lattice.push_back({5e6 + 0.25 * j, 0.25 * i, 3.0});
  }
  EXPECT_NEAR(features::resolution(CellGrid(cloud_of(lattice), 1.0)), 0.25, 1e-5);
  EXPECT_TRUE(std::isinf(features::resolution(CellGrid(cloud_of(lattice), 0.2))));
}

TEST(Normals, OfASphereAreItsRadii) {
  std::mt19937 random(4);
  Points points;
  for (int i = 0; i < 5000; ++i) {
    Eigen::Vector3d p(uniform(random), uniform(random), uniform(random));
    if (p.norm() < 0.1) continue;
    p = Eigen::Vector3d(100.0, 0.0, 0.0) + 2.0 * p.normalized();
    points.push_back({p.x(), p.y(), p.z()});
  }
  CellGrid grid(cloud_of(points), 0.5);
  features::estimate_normals(grid, {0.4, std::array<double, 3>{100.0, 0.0, 0.0}});
  const CloudView view = grid.cloud().view();
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const auto p = grid.cloud().point(i);
    const Eigen::Vector3d inwards =
        -(Eigen::Vector3d(p[0], p[1], p[2]) - Eigen::Vector3d(100.0, 0.0, 0.0)).normalized();
    const Eigen::Vector3d normal(view.normals(0)[i], view.normals(1)[i], view.normals(2)[i]);
    EXPECT_NEAR(normal.norm(), 1.0, 1e-5);
    EXPECT_GT(normal.dot(inwards), 0.98);
  }
}

TEST(Normals, WithoutAViewpointAreUpright) {
  CellGrid grid(cloud_of(room(3000, 2)), 1.0);
  features::estimate_normals(grid, {0.8, std::nullopt});
  for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_FALSE(grid.cloud().view().normals(2)[i] < 0.0f);
}

TEST(Normals, OfTooFewPointsAreMissing) {
  const Points points{{0, 0, 0}, {0.1, 0, 0}, {50, 0, 0}, {90, 0, 0}, {90, 0, 0}, {90, 0, 0}};
  CellGrid grid(cloud_of(points), 1.0);
  features::estimate_normals(grid, {1.0, std::nullopt});
  for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_TRUE(std::isnan(grid.cloud().view().normals(0)[i])) << i;
  EXPECT_THROW(features::estimate_normals(grid, {0.0, std::nullopt}), std::invalid_argument);
  EXPECT_THROW(features::estimate_normals(grid, {1.0, std::array<double, 3>{0, std::nan(""), 0}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace consimd::test
