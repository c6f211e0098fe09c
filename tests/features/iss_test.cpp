#include <consimd/features/iss.hpp>

#include <gtest/gtest.h>
#include <oneapi/tbb/task_arena.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene.hpp"

namespace consimd::test {
namespace {

using features::CellGrid;
using features::IssOptions;

Eigen::Vector3d place(const CellGrid& grid, std::size_t row) { return Eigen::Vector3d(grid.cloud().point(row).data()); }

std::vector<std::uint32_t> rows_within(const CellGrid& grid, std::size_t row, double radius) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t other = 0; other < grid.size(); ++other) {
    if ((place(grid, other) - place(grid, row)).norm() <= radius) found.push_back(other);
  }
  return found;
}

/// As the paper has it, in double, without its weights; 0 of points that are not salient.
std::vector<double> textbook_saliencies(const CellGrid& grid, const IssOptions& options) {
  std::vector<double> saliencies(grid.size(), 0.0);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const std::vector<std::uint32_t> near = rows_within(grid, i, options.radius);
    if (near.size() < options.fewest_neighbours + 1) continue;
    const auto count = static_cast<double>(near.size());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const std::uint32_t row : near) mean += place(grid, row) / count;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const std::uint32_t row : near) {
      covariance += (place(grid, row) - mean) * (place(grid, row) - mean).transpose() / count;
    }
    const Eigen::Vector3d values = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues();
    const bool salient =
        values[1] < options.second_to_first * values[2] && values[0] < options.third_to_second * values[1];
    if (salient) saliencies[i] = values[0];
  }
  return saliencies;
}

TEST(Iss, IsThePapers) {
  const CellGrid grid(cloud_of(room(1500, 8)), 1.0);
  for (const IssOptions& options :
       {IssOptions{.radius = 0.9, .suppression_radius = 0.6},
        IssOptions{.radius = 0.7, .suppression_radius = 1.0, .second_to_first = 0.6, .third_to_second = 0.3},
        IssOptions{.radius = 0.5, .suppression_radius = 0.3, .fewest_neighbours = 12}}) {
    const std::vector<std::uint32_t> found = iss_keypoints(grid, options);
    const std::vector<double> saliencies = textbook_saliencies(grid, options);
    // Where two saliencies differ by less, single precision may take the other: those of points that have the same
    // neighbours do not differ at all.
    constexpr double kMargin = 0.002;
    std::size_t certain = 0;
    for (std::uint32_t row = 0; row < grid.size(); ++row) {
      double most = 0.0;
      for (const std::uint32_t other : rows_within(grid, row, options.suppression_radius)) {
        if (other != row) most = std::max(most, saliencies[other]);
      }
      const bool is_keypoint = std::binary_search(found.begin(), found.end(), row);
      if (saliencies[row] * (1.0 - kMargin) > most) {
        EXPECT_TRUE(is_keypoint) << row;
        ++certain;
      }
      const bool certainly_none = saliencies[row] * (1.0 + kMargin) < most || saliencies[row] == 0.0;
      EXPECT_FALSE(certainly_none && is_keypoint) << row;
    }
    EXPECT_GE(certain, 20u);
    EXPECT_LE(found.size() - certain, certain / 3);
    tbb::task_arena one(1);
    EXPECT_EQ(one.execute([&] { return iss_keypoints(grid, options); }), found);
  }
}

TEST(Iss, KeepsOneOfEquals) {
  // The corners of three squares, of the same shape, apart from one another; in each all corners are equally salient.
  Points points;
  for (const double x : {0.0, 10.0, 20.0}) {
    for (const double z : {0.0, 0.25}) {
      for (const double y : {0.0, 1.0}) points.insert(points.end(), {{x, y, z}, {x + 0.5, y, z}});
    }
  }
  const CellGrid grid(cloud_of(points), 2.0);
  EXPECT_EQ(iss_keypoints(grid, {.radius = 2.0, .suppression_radius = 2.0}).size(), 3u);
  EXPECT_TRUE(iss_keypoints(grid, {.radius = 2.0, .suppression_radius = 2.0, .fewest_neighbours = 8}).empty());
  EXPECT_TRUE(iss_keypoints(CellGrid(Cloud(), 1.0), {.radius = 1.0, .suppression_radius = 1.0}).empty());
}

TEST(Iss, NamesWhatIsWrong) {
  const CellGrid grid(cloud_of(room(100, 1)), 1.0);
  const auto fault = [&grid](const IssOptions& options) -> std::string {
    try {
      static_cast<void>(iss_keypoints(grid, options));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_TRUE(fault({.radius = 2.0, .suppression_radius = 1.0}).starts_with("radius is 2"));
  EXPECT_TRUE(fault({.radius = 1.0}).starts_with("suppression_radius is 0"));
  EXPECT_TRUE(fault({.radius = 1.0, .suppression_radius = 1.0, .second_to_first = 0.0}).starts_with("second_to_first"));
  EXPECT_TRUE(fault({.radius = 1.0, .suppression_radius = 1.0, .third_to_second = 1.5}).starts_with("third_to_second"));
}

}  // namespace
}  // namespace consimd::test
