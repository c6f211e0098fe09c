// Descriptors beside those of the Point Cloud Library, of the same points and normals.
#include <consimd/features/fpfh.hpp>
#include <consimd/features/normals.hpp>

#include <gtest/gtest.h>
#include <pcl/features/fpfh.h>
#include <pcl/point_types.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "scene.hpp"

namespace consimd::test {
namespace {

TEST(FpfhOfPcl, IsThatOfConsimd) {
  constexpr double kRadius = 0.9;
  features::CellGrid grid(cloud_of(room(6000, 6)), 1.0);
  features::estimate_normals(grid, {1.0, std::array<double, 3>{0.0, 0.0, 1.5}});
  const CloudView view = grid.cloud().view();
  const pcl::PointCloud<pcl::PointXYZ>::Ptr points(new pcl::PointCloud<pcl::PointXYZ>);
  const pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    ASSERT_TRUE(std::isfinite(view.normals(0)[i]));
    const std::array<double, 3> p = grid.cloud().point(i);
    points->emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
    normals->emplace_back(view.normals(0)[i], view.normals(1)[i], view.normals(2)[i]);
  }
  pcl::FPFHEstimation<pcl::PointXYZ, pcl::Normal, pcl::FPFHSignature33> estimation;
  estimation.setInputCloud(points);
  estimation.setInputNormals(normals);
  estimation.setRadiusSearch(kRadius);
  pcl::PointCloud<pcl::FPFHSignature33> expected;
  estimation.compute(expected);
  std::vector<std::uint32_t> rows(grid.size());
  std::iota(rows.begin(), rows.end(), 0U);
  const features::Descriptors found = features::fpfh(grid, rows, kRadius);
  ASSERT_EQ(found.rows, rows);
  // A pair near the border of two bins may be counted in the other one; what that changes grows with the weight of the
  // neighbour whose histogram it is, one over its squared distance.
  std::size_t off = 0, far_off = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t c = 0; c < 33; ++c) {
      const float difference = std::abs(found.values[33 * i + c] - expected[i].histogram[c]);
      off += difference < 0.01F ? 0U : 1U;
      far_off += difference < 1.0F ? 0U : 1U;
    }
  }
  const std::size_t components = 33 * rows.size();
  EXPECT_LE(off, components / 100);        // 1204 of 198 000 with PCL 1.13
  EXPECT_LE(far_off, components / 10000);  // 4
}

}  // namespace
}  // namespace consimd::test
